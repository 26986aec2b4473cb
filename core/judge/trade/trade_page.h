// The HTML report of a trade of speed for accuracy.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/judge/trade/trade_result.h"
#include "core/judge/trade/trade_view.h"

namespace raywalk {

// The truth of one viewpoint and the error of settings there; CV_8UC3, at thumbnail size.
struct TradePictures {
  std::string view{};
  cv::Mat truth{};
  std::vector<cv::Mat> errors{};  // of each setting; empty: not shown
};

// Renders the view of middle distance in every setting, or where there are many in those on the
// PSNR front and nearest to it. Throws as Renderer does; Interrupted.
TradePictures trade_pictures(const Trade& trade, std::span<const TradeRoom> rooms);

// One self-contained HTML page: the front, the effect of each parameter alone, every setting.
std::string trade_page(const Trade& trade, const TradePictures& pictures);

}  // namespace raywalk
