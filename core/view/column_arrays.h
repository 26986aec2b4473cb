// Arrays that the column kernels work on.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/view/column_kernels.h"

namespace raywalk {

// Positions of the rows of an output column in a map's column: row, and fraction of the way to row
// + 1.
struct RowMapping {
  RowMapping(int rows, int map_rows)
      : upper(static_cast<size_t>(rows)),
        fraction(static_cast<size_t>(rows)),
        nearest(static_cast<size_t>(rows)),
        first_row(static_cast<size_t>(map_rows) + 1, rows) {
    for (int row = 0; row < rows; ++row) {
      const double v = std::clamp((row + 0.5) * map_rows / rows - 0.5, 0.0, map_rows - 1.0);
      const auto i = static_cast<size_t>(row);
      upper[i] = std::min(static_cast<int>(v), map_rows - 2);
      fraction[i] = static_cast<float>(v - upper[i]);
      nearest[i] = static_cast<int>(std::lround(v));
    }
    for (int row = rows - 1, map_row = map_rows; map_row >= 0; --map_row) {
      while (row >= 0 && nearest[static_cast<size_t>(row)] >= map_row) --row;
      first_row[static_cast<size_t>(map_row)] = row + 1;
    }
  }
  std::vector<int> upper;
  std::vector<float> fraction;
  std::vector<int> nearest;
  std::vector<int> first_row;  // of the rows that are nearest to each map row; one more for the end
};

// Storage for SamplePositions.
struct PositionArrays {
  explicit PositionArrays(int rows)
      : offset_left(static_cast<size_t>(rows + kSampleLookAhead)),
        offset_right(offset_left),
        weight_right(offset_left.size()),
        weight_lower(weight_right) {}
  SamplePositions positions() {
    return {offset_left.data(), offset_right.data(), weight_right.data(), weight_lower.data()};
  }
  std::vector<std::int32_t> offset_left, offset_right;
  std::vector<std::int32_t> weight_right, weight_lower;
};

// Storage for ProjectedPoints.
struct PointArrays {
  explicit PointArrays(int rows)
      : omega(static_cast<size_t>(rows)),
        u(omega),
        v(omega),
        widening(omega),
        magnification(omega),
        first_column(omega.size()),
        last_column(first_column),
        first_row(first_column),
        last_row(first_column),
        left(first_column),
        right(first_column),
        down(first_column),
        is_wide(first_column) {}
  ProjectedPoints points() {
    return {omega.data(),
            u.data(),
            v.data(),
            widening.data(),
            magnification.data(),
            first_column.data(),
            last_column.data(),
            first_row.data(),
            last_row.data(),
            left.data(),
            right.data(),
            down.data(),
            is_wide.data()};
  }
  bool operator==(const PointArrays&) const = default;

  std::vector<float> omega, u, v, widening, magnification;
  std::vector<std::int32_t> first_column, last_column, first_row, last_row;
  std::vector<std::int32_t> left, right, down, is_wide;
};

}  // namespace raywalk
