#include "build_lf/gains/gain_spots.h"

#include <algorithm>
#include <cmath>

#include "build_lf/gains/patch_ratios.h"
#include "core/base/median.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

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
