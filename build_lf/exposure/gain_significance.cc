#include "build_lf/exposure/gain_significance.h"

#include <algorithm>
#include <cmath>

#include "build_lf/exposure/patch_ratios.h"
#include "core/base/median.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

// Errors that both halves share, because their surfaces are alike; smaller for a whole picture,
// which averages over many surfaces.
constexpr double kWholeModelError = 0.005;
constexpr double kLocalModelError = 0.01;

// Solid angles of the measured patches, which sum to 1; all 0 if none is measured.
std::vector<double> patch_weights(std::span<const bool> measured) {
  std::vector<double> weights(kPatches, 0.0);
  double total = 0.0;
  for (size_t patch = 0; patch < weights.size(); ++patch) {
    if (!measured[patch]) continue;
    const auto phi = static_cast<double>(patch % kPatchesPhi);
    weights[patch] = std::sin((phi + 0.5) / kPatchesPhi * kPi);
    total += weights[patch];
  }
  for (double& weight : weights) weight = total > 0.0 ? weight / total : 0.0;
  return weights;
}

double mean_of(std::span<const double> values, std::span<const double> weights) {
  double sum = 0.0;
  for (size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i];
  return sum;
}

// Root mean square of values less their mean.
double variation_of(std::span<const double> values, std::span<const double> weights) {
  const double mean = mean_of(values, weights);
  double sum = 0.0;
  for (size_t i = 0; i < values.size(); ++i) {
    sum += weights[i] * (values[i] - mean) * (values[i] - mean);
  }
  return std::sqrt(sum);
}

// Half the difference of two halves: the standard error of their mean.
std::vector<double> half_difference(std::span<const double> a, std::span<const double> b) {
  std::vector<double> difference(a.size());
  for (size_t i = 0; i < a.size(); ++i) difference[i] = 0.5 * (a[i] - b[i]);
  return difference;
}

// 0 for sizes below twice the error, 1 above four times.
double kept_share(double size, double error) {
  return std::clamp(0.5 * size / error - 1.0, 0.0, 1.0);
}

double norm(const std::array<double, 3>& values) {
  return std::hypot(values[0], values[1], values[2]) / std::sqrt(3.0);
}

size_t index_of(int theta, int phi) {
  const int patch = theta * kPatchesPhi + phi;
  return static_cast<size_t>(patch);
}

double median_around(std::span<const double> patches, int theta, int phi) {
  constexpr int kReach = 2;
  // Patches are narrower towards the poles: more of them are as wide. Within an eighth of the
  // circle to both sides the median still belongs to a lens that covers a quarter.
  constexpr int kMostSideways = kPatchesTheta / 8;
  const double width = std::sin((phi + 0.5) / kPatchesPhi * kPi);
  const int sideways = std::min(static_cast<int>(std::lround(kReach / width)), kMostSideways);
  std::vector<double> values;
  for (int t = theta - sideways; t <= theta + sideways; ++t) {
    const int column = (t + kPatchesTheta) % kPatchesTheta;
    for (int p = std::max(0, phi - kReach); p <= std::min(kPatchesPhi - 1, phi + kReach); ++p) {
      values.push_back(patches[index_of(column, p)]);
    }
  }
  return median(std::move(values));
}

}  // namespace

KeptGains keep_significant(const PatchGains& gains, const std::array<PatchGains, 2>& halves,
                           std::span<const bool> measured) {
  const std::vector<double> weights = patch_weights(measured);
  std::array<double, 3> whole{};
  std::array<double, 3> whole_error{};
  std::array<double, 3> local{};
  std::array<double, 3> local_error{};
  for (size_t c = 0; c < 3; ++c) {
    const std::vector<double> difference = half_difference(halves[0][c], halves[1][c]);
    whole[c] = mean_of(gains[c], weights);
    whole_error[c] = mean_of(difference, weights);
    local[c] = variation_of(gains[c], weights);
    local_error[c] = variation_of(difference, weights);
  }
  const double whole_share =
      kept_share(norm(whole), std::hypot(kWholeModelError, norm(whole_error)));
  const double local_share =
      kept_share(norm(local), std::hypot(kLocalModelError, norm(local_error)));
  KeptGains kept;
  kept.local = local_share > 0.0;
  for (size_t c = 0; c < 3; ++c) {
    kept.whole[c] = whole_share * whole[c];
    if (!kept.local) continue;
    for (const double gain : gains[c]) kept.patches[c].push_back(local_share * (gain - whole[c]));
  }
  return kept;
}

std::vector<double> without_spots(std::span<const double> patches) {
  constexpr double kSpot = 0.1;
  std::vector<double> result(patches.begin(), patches.end());
  for (int theta = 0; theta < kPatchesTheta; ++theta) {
    for (int phi = 0; phi < kPatchesPhi; ++phi) {
      double& patch = result[index_of(theta, phi)];
      const double usual = median_around(patches, theta, phi);
      if (std::fabs(patch - usual) > kSpot) patch = usual;
    }
  }
  return result;
}

}  // namespace raywalk::build_lf
