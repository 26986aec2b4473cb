// Viewpoints with known true pictures, on which a trade of speed for accuracy is measured.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluate/validation/truth_views.h"
#include "core/room/room.h"

namespace raywalk {

// A viewpoint and its true picture: captured between the lines, or a station that was held out of
// `room` (held_out_views.h).
struct TradeView {
  std::string name{};
  const Room* room = nullptr;  // the view is rendered from it; must outlive this
  PlanPoint viewpoint{};
  std::optional<double> height_m{};  // as TruthView has it
  cv::Mat truth{};                   // CV_8UC3 in BGR order, width = 2 * height
  cv::Mat mask{};                    // CV_8UC1 of the same size, 0 = not compared; empty: all is
};

// At most `most` of the truths, spread over the distance from the lines. Throws Error unless all
// have one width.
std::vector<TradeView> captured_views(const Room& room, const std::vector<TruthView>& truths,
                                      std::size_t most);

}  // namespace raywalk
