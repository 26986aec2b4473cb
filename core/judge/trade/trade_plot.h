// The plots of the report of a trade, from the document of trade.json. Every point is a setting,
// linked to its card on the page.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/report/html_page.h"

namespace raywalk {

// PSNR over the time of a view: all settings, and the front as steps. Settings on the front are
// filled and numbered.
HtmlFigure trade_plot(const nlohmann::ordered_json& document);

// PSNR of held-out stations over that against the truth, of settings with both.
HtmlFigure held_out_plot(const nlohmann::ordered_json& document);

}  // namespace raywalk
