// A trade of speed for accuracy as a plot.
#pragma once

#include <string>

#include "render/trade/trade_result.h"

namespace raywalk::render {

// Where a setting is found on the page: "setting-12" for index 11.
std::string anchor_of(std::size_t setting);

// PSNR over the time of a view: every setting as a point that leads to its anchor, and the front as
// steps. Settings on the front are filled and carry their number. An <svg> element.
std::string trade_plot(const Trade& trade);

}  // namespace raywalk::render
