// Time and accuracy of one setting.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "core/evaluate/measured_settings.h"
#include "core/evaluate/trade_sweep.h"
#include "core/evaluate/truth_views.h"
#include "core/room/room.h"

namespace raywalk {

struct SettingMeasurement {
  const Room& room;
  std::span<const TrueView> views;  // of one width
  int repetitions = 1;              // of every view
  const TimeSource& time_source;
};

// The time of every view after a warm-up, each beside one of cv::remap; then, so that scoring does
// not disturb the times, the scores. An image smaller than its truth is enlarged before it is
// scored; its time does not include that. The number of threads in use (core/base/parallel.h) is
// changed while views are timed.
//
// {"ms", "ratio" to a remap, "remap_ms": medians over all runs of all views, "remap_spread": how
// far the upper quartile of the remap's time is above the least, as a part of it, "psnr_db",
// "ws_psnr_db", "ssim", "fsim": means over the views}. Throws Error as Renderer does; Interrupted.
nlohmann::ordered_json measured(const TradeSetting& setting, const SettingMeasurement& by);

}  // namespace raywalk
