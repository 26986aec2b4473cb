// Time, memory and accuracy of one setting.
#pragma once

#include <span>

#include "core/panorama/pitch_remap.h"
#include "render/trade/trade_result.h"
#include "render/trade/trade_setting.h"
#include "render/trade/trade_view.h"
#include "render/view/renderer.h"

namespace raywalk::render {

// Measures all but e_connect. First the memory that the first view takes in the room opened anew,
// then times: every view `repetitions` times after one that does not count, each paired with one
// run of `yardstick`; then, so that scoring does not disturb them, the scores. A picture smaller
// than its truth is enlarged before it is scored, which is not part of its time. The number of
// threads in use (core/base/parallel.h) is changed meanwhile and set back.
// Throws Error as Renderer does; Interrupted.
TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 int repetitions, PitchRemap* yardstick);

// Means over the views, rendered with that setting. Throws as measure_setting does.
ViewScores score_setting(const TradeSetting& setting, std::span<const TradeView> views);

// The view of a setting at the size of its truth, as it is scored.
cv::Mat picture_of(const TradeSetting& setting, const TradeView& view);

}  // namespace raywalk::render
