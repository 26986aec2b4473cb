// How the rows of a view lie between those of its distances.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace raywalk {

struct RowMap {
  RowMap() = default;
  RowMap(int output_rows, int distance_rows)
      : per_distance(static_cast<double>(output_rows) / distance_rows) {
    if (distance_rows == 0) return;  // of an initial view
    for (int i = 0; i < output_rows; ++i) {
      const double at = (i + 0.5) / per_distance - 0.5;
      nearest.push_back(std::clamp(static_cast<int>(std::floor(at + 0.5)), 0, distance_rows - 1));
      down.push_back(static_cast<float>(at - nearest.back()));
    }
    for (int row = 0; row <= distance_rows; ++row) {
      first.push_back(static_cast<int>(std::ranges::lower_bound(nearest, row) - nearest.begin()));
    }
  }

  // `per_distance` if it is a whole number, else 0.
  int per_row() const {
    const auto whole = static_cast<int>(per_distance);
    return whole == per_distance ? whole : 0;
  }

  double per_distance = 1.0;  // output rows per row of the distances
  // Of each output row, the nearest row of the distances, and how far below its middle it is.
  std::vector<int> nearest;
  std::vector<float> down;
  // Of each row of the distances, the first output row that it is nearest to; and the end.
  std::vector<int> first;
};

}  // namespace raywalk
