// A trade of speed for accuracy as a page to look at.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/trade/trade_result.h"
#include "render/trade/trade_view.h"

namespace raywalk::render {

// One viewpoint as it is and as settings err there; CV_8UC3, small.
struct TradePictures {
  std::string view{};
  cv::Mat truth{};
  std::vector<cv::Mat> errors{};  // of each setting; empty: not shown
};

// Renders the view of middle distance once more: in every setting, or where there are many in those
// on the PSNR front and nearest to it. Throws as Renderer does; Interrupted.
TradePictures trade_pictures(const Trade& trade, std::span<const TradeRoom> rooms);

// One self-contained HTML page: the front, what each parameter does alone, every setting.
std::string trade_page(const Trade& trade, const TradePictures& pictures);

}  // namespace raywalk::render
