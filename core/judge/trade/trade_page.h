// The HTML report of a trade of speed for accuracy.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/judge/trade/trade_result.h"
#include "core/judge/trade/trade_view.h"

namespace raywalk {

// The truth of the pictured view and the error of settings there; CV_8UC3, at thumbnail size.
struct TradePictures {
  cv::Mat truth{};
  std::vector<cv::Mat> errors{};  // of each setting; empty: not shown
};

// Renders the pictured view in every setting, or where there are many in those on the
// PSNR front and nearest to it. Throws as Renderer does; Interrupted.
TradePictures trade_pictures(const Trade& trade, std::span<const TradeRoom> rooms);

// One self-contained HTML page: the front, the effect of each parameter alone, every setting.
// `document`: of trade.json.
std::string trade_page(const nlohmann::ordered_json& document, const TradePictures& pictures);

}  // namespace raywalk
