// Curves of the worst error found around each of many arguments.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/report/svg_plot.h"

namespace raywalk::bench {

// What errors are measured against: 50 digits.
using Exact = boost::multiprecision::cpp_bin_float_50;

// Random numbers that are the same everywhere.
class RandomArguments {
 public:
  explicit RandomArguments(unsigned seed);
  double uniform(double least, double most);
  double log_uniform(double least, double most);

 private:
  unsigned long long state_;
};

struct ErrorCurves {
  LinePlot plot{};  // title and labels; scales, series and what they hold are filled in
  std::vector<std::string> names{};
  double least = 1e-6;  // range of the arguments
  double most = 1.0;
  // One case near an argument: the error of each curve.
  std::function<std::vector<double>(double argument, RandomArguments& random)> errors{};
};

// Draws every curve, log-log, and writes the plot to `file`. An error of exactly 0 counts as
// `kNoError`, below what long double can resolve.
inline constexpr double kNoError = 1e-20;
void write_error_curves(ErrorCurves curves, const std::filesystem::path& file);

}  // namespace raywalk::bench
