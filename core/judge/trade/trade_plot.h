// A trade of speed for accuracy as a plot.
#pragma once

#include <string>

#include "core/judge/trade/trade_result.h"

namespace raywalk {

// HTML anchor of a setting on the page: "setting-12" for index 11.
std::string anchor_of(std::size_t setting);

// PSNR over the time of a view: every setting as a point linked to its anchor, and the front as
// steps. Settings on the front are filled and numbered. An <svg> element.
std::string trade_plot(const Trade& trade);

}  // namespace raywalk
