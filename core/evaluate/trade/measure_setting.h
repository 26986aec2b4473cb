// Time and accuracy of one setting.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

#include "core/evaluate/trade/trade_sweep.h"
#include "core/evaluate/trade/trade_views.h"
#include "core/evaluate/trade/view_time.h"
#include "core/evaluate/validation/view_scores.h"
#include "core/panorama/pitch_remap.h"

namespace raywalk {

// How views are timed.
struct ViewTimer {
  int repetitions = 1;              // of every view
  PitchRemap* yardstick = nullptr;  // run beside every view
  TimeSource source = wall_time_s;
};

struct TradeMeasurement {
  ViewTime time{};      // over views and repetitions
  ViewScores scores{};  // means over the views
};

// The time of every view, `repetitions` times after a warm-up, each run paired with the yardstick;
// then, so that scoring does not disturb the times, the scores. An image smaller than its truth is
// enlarged before it is scored; its time does not include that. The number of threads in use
// (core/base/parallel.h) is changed while views are timed. Throws Error as Renderer does;
// Interrupted.
TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 const ViewTimer& timer);

// The view of a setting at the size of its truth, as it is scored.
cv::Mat image_of(const TradeSetting& setting, const TradeView& view);

}  // namespace raywalk
