// Times of pieces of work and their median, which a shared machine disturbs least.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

namespace raywalk {

// Seconds that passed, and seconds that all threads of this process computed. Where other programs
// compete for the cores the second says more.
struct Times {
  double wall_s = 0.0;
  double cpu_s = 0.0;
};

// Runs `work` and returns the times it took.
template <typename Work>
Times times_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  work();
  const std::clock_t cpu = std::clock() - cpu_start;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return {wall.count(), static_cast<double>(cpu) / CLOCKS_PER_SEC};
}

// `values` must not be empty; of an even number of values the upper middle one.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace raywalk
