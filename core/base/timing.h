// Times of pieces of work.
#pragma once

#include <chrono>
#include <ctime>

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

}  // namespace raywalk
