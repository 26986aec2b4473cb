// Curves of the largest error found near each argument.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace raywalk::bench {

// Reference arithmetic with 50 digits.
using Exact = boost::multiprecision::cpp_bin_float_50;

// Random numbers that are the same on every platform.
class RandomArguments {
 public:
  explicit RandomArguments(unsigned seed);
  double uniform(double least, double most);
  double log_uniform(double least, double most);

 private:
  unsigned long long state_;
};

struct ErrorCurves {
  std::vector<std::string> names{};
  double least = 1e-6;  // range of the arguments
  double most = 1.0;
  // The error of each curve for one random case near an argument.
  std::function<std::vector<double>(double argument, RandomArguments& random)> errors{};
};

// Writes a table of the arguments and the error of every curve. An error of exactly 0 counts as
// `kNoError`, below the resolution of long double.
inline constexpr double kNoError = 1e-20;
void write_error_curves(const ErrorCurves& curves, const std::filesystem::path& file);

// Writes the tables that docs/measured.md shows into an existing directory, replacing those of the
// same names. The output is deterministic. Throws Error if a file cannot be written.
void write_model_errors(const std::filesystem::path& directory);

}  // namespace raywalk::bench
