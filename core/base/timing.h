// Wall-clock and CPU time of a function.
#pragma once

#include <chrono>
#include <ctime>

namespace raywalk {

// Wall-clock time and CPU time of all threads, seconds. CPU time is the better measure where other
// programs compete for the cores.
struct Times {
  double wall_s = 0.0;
  double cpu_s = 0.0;
};

// Runs `work` and measures it.
template <typename Work>
Times times_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  work();
  const std::clock_t cpu = std::clock() - cpu_start;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return {wall.count(), static_cast<double>(cpu) / CLOCKS_PER_SEC};
}

}  // namespace raywalk
