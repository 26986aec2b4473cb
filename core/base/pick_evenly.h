// A sample spread evenly over a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace raywalk {

// At most `most` of `count` indices, spread evenly.
inline std::vector<int> pick_evenly(int count, int most) {
  const int picked = std::min(count, most);
  std::vector<int> indices;
  indices.reserve(static_cast<std::size_t>(picked));
  for (int i = 0; i < picked; ++i) {
    indices.push_back(static_cast<int>((i + 0.5) * double(count) / picked));
  }
  return indices;
}

}  // namespace raywalk
