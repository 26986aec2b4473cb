// What a trade of speed for accuracy is measured on: viewpoints whose true pictures are known.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/room/room.h"

namespace raywalk::render {

// A viewpoint and what is seen from it. Where the truth comes from does not matter here: captured
// between the lines (captured_views.h), or a station that `room` does without.
struct TradeView {
  std::string name{};
  const Room* room = nullptr;  // that the view is rendered from; must outlive it
  PlanPoint viewpoint{};
  double line_distance_m = 0.0;  // in the plan, to the nearest line that serves the view
  cv::Mat truth{};               // CV_8UC3 in BGR order, width = 2 * height
  cv::Mat mask{};                // CV_8UC1 of the same size, 0 = not compared; empty: all is
};

// A room that settings may render from, and every view in it. All rooms of a trade have the same
// views in the same order, and all truths the same size.
struct TradeRoom {
  const Room* room = nullptr;  // must outlive it
  std::string depth{};         // where its distances come from, as depth_name says
  std::vector<TradeView> views{};
};

}  // namespace raywalk::render
