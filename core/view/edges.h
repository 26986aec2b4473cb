// Pass 3: where the distances of a view have an edge, they are found at twice the resolution.
//
// A pixel at a silhouette is in part foreground, in part background. One distance makes it either:
// a stair in the outline, and a speck where the distance is wrong. So each pixel beside a step of
// the distances is divided into 2 x 2, and each quarter gets the distance of one of the surfaces
// around it: the nearer one where the nearest map that shows either shows that one, to more than
// half by bilinear weight. Pass 4 averages the quarters' samples.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/view/distance_view.h"

namespace raywalk {

// A quarter of a pixel of the distances.
struct EdgeQuarter {
  float inverse = 0.0f;             // distance from the eye, 1/m
  std::int8_t right = 0, down = 0;  // the pixel around it, -1 to 1, whose surface it is on
};

struct EdgePixel {
  int row = 0;
  std::array<EdgeQuarter, 4> quarter{};  // upper left, lower left, upper right, lower right
};

class Edges {
 public:
  // Of the columns [first, first + count) of the distances, around the seam.
  void compute(const DistanceView& distances, int first, int count);

  // Of a column, from the top.
  std::span<const EdgePixel> column(int theta) const {
    return columns_[static_cast<std::size_t>(theta)];
  }

 private:
  std::vector<std::vector<EdgePixel>> columns_;
};

}  // namespace raywalk
