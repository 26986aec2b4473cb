// Time, memory and accuracy of one setting.
#pragma once

#include <span>

#include "core/judge/trade/trade_result.h"
#include "core/judge/trade/trade_setting.h"
#include "core/judge/trade/trade_view.h"
#include "core/panorama/pitch_remap.h"
#include "core/view/renderer.h"

namespace raywalk {

// How views are timed.
struct ViewTimer {
  int repetitions = 1;              // of every view
  PitchRemap* yardstick = nullptr;  // run beside every view
  TimeSource source{};
};

// Measures everything but e_connect: first the memory of the first view in a newly opened room,
// then the time, and last, so that scoring does not disturb the times, the scores. A picture
// smaller than its truth is enlarged before it is scored; its time does not include that. Throws
// Error as Renderer does; Interrupted.
TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 const ViewTimer& timer);

// The time of every view, `repetitions` times after a warm-up, each run paired with the yardstick.
// The number of threads in use (core/base/parallel.h) is changed during the measurement and
// restored. Throws as measure_setting does.
ViewTime measure_time(const TradeSetting& setting, std::span<const TradeView> views,
                      const ViewTimer& timer);

// Mean scores of the views rendered with a setting. Throws as measure_setting does.
ViewScores score_setting(const TradeSetting& setting, std::span<const TradeView> views);

// The view of a setting at the size of its truth, as it is scored.
cv::Mat picture_of(const TradeSetting& setting, const TradeView& view);

}  // namespace raywalk
