// The median.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace raywalk {

// The median of `values`: at least one, none NaN. The upper of the two middle values if their
// number is even.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace raywalk
