#include "tests/bench/error_curves.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/files/atomic_output.h"

namespace raywalk::bench {
namespace {

constexpr int kPerDecade = 8;
constexpr int kCasesPerPoint = 150;

}  // namespace

RandomArguments::RandomArguments(unsigned seed) : state_(seed) {}

// SplitMix64; the distributions of <random> are implementation-defined.
double RandomArguments::uniform(double least, double most) {
  state_ += 0x9e3779b97f4a7c15ULL;
  unsigned long long z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  z ^= z >> 31;
  return least + static_cast<double>(z >> 11) * 0x1p-53 * (most - least);
}

double RandomArguments::log_uniform(double least, double most) {
  return std::exp(uniform(std::log(least), std::log(most)));
}

void write_error_curves(const ErrorCurves& curves, const std::filesystem::path& file) {
  RandomArguments random(1);
  std::string table = "argument";
  for (const std::string& name : curves.names) table += "," + name;
  const double decades = std::log10(curves.most / curves.least);
  const int points = static_cast<int>(std::lround(decades * kPerDecade));
  const double step = std::pow(curves.most / curves.least, 1.0 / points);
  for (int i = 0; i < points; ++i) {
    const double low = curves.least * std::pow(step, i);
    std::vector<double> worst(curves.names.size(), kNoError);
    for (int n = 0; n < kCasesPerPoint; ++n) {
      const auto errors = curves.errors(random.log_uniform(low, low * step), random);
      for (size_t c = 0; c < worst.size(); ++c) worst[c] = std::max(worst[c], errors[c]);
    }
    table += fmt::format("\n{:.6g}", low * std::sqrt(step));
    for (const double error : worst) table += fmt::format(",{:.4g}", error);
  }
  write_file_atomically(file, table + "\n");
}

}  // namespace raywalk::bench
