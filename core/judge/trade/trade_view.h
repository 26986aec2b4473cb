// Viewpoints with known true pictures, on which a trade of speed for accuracy is measured.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// A viewpoint and its true picture: captured between the lines (captured_views.h), or a station
// that was left out of `room` (held_out_views.h).
struct TradeView {
  std::string name{};
  const Room* room = nullptr;  // the view is rendered from it; must outlive this
  PlanPoint viewpoint{};
  std::optional<double> height_m{};  // as TruthView has it
  double line_distance_m = 0.0;      // in the plan, to the nearest line that serves the view
  cv::Mat truth{};                   // CV_8UC3 in BGR order, width = 2 * height
  cv::Mat mask{};                    // CV_8UC1 of the same size, 0 = not compared; empty: all is
};

// A room that settings may render from, and every view in it. All rooms of a trade have the same
// views in the same order, and all truths the same size.
struct TradeRoom {
  const Room* room = nullptr;  // must outlive it
  std::string depth{};         // source of its distances: depth_name()
  std::vector<TradeView> views{};
};

}  // namespace raywalk
