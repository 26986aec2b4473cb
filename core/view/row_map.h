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
    for (int i = 0; i < output_rows; ++i) {
      const double at = (i + 0.5) / per_distance - 0.5;
      const int row =
          std::clamp(static_cast<int>(std::floor(at)), 0, std::max(distance_rows - 2, 0));
      upper.push_back(row);
      part.push_back(static_cast<float>(at - row));
      nearest.push_back(std::clamp(static_cast<int>(std::floor(at + 0.5)), 0, distance_rows - 1));
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
  std::vector<int> upper;     // of the two rows around each output row
  std::vector<float> part;    // of the way to the lower one
  std::vector<int> nearest;
  std::vector<int>
      first;  // of each row of the distances, the first row it is nearest to; and the end
};

}  // namespace raywalk
