#include "build_lf/exposure/gain_significance.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

// Errors that both halves share, because their surfaces are alike; smaller for a whole picture,
// which averages over many surfaces.
constexpr double kWholeModelError = 0.005;
constexpr double kLocalModelError = 0.01;

// The width of a row of patches, relative to the one at the horizon.
double width_of(int phi) { return std::sin((phi + 0.5) / kPatchesPhi * kPi); }

// Solid angles of the measured patches, which sum to 1; all 0 if none is measured.
Eigen::RowVectorXd patch_weights(std::span<const bool> measured) {
  Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(kPatches);
  for (int patch = 0; patch < kPatches; ++patch) {
    if (measured[static_cast<size_t>(patch)]) weights[patch] = width_of(patch % kPatchesPhi);
  }
  const double total = weights.sum();
  return total > 0.0 ? weights / total : weights;
}

// 0 for sizes below twice the error, 1 above four times. Both of the three channels.
double kept_share(const Eigen::RowVector3d& size, const Eigen::RowVector3d& error,
                  double model_error) {
  const double all = std::hypot(model_error, error.norm() / std::sqrt(3.0));
  return std::clamp(0.5 * size.norm() / std::sqrt(3.0) / all - 1.0, 0.0, 1.0);
}

double median_around(const Eigen::VectorXd& patches, int theta, int phi) {
  constexpr int kReach = 2;
  // Patches are narrower towards the poles: more of them are as wide. Within an eighth of the
  // circle to both sides the median still belongs to a lens that covers a quarter.
  constexpr int kMostSideways = kPatchesTheta / 8;
  const int sideways =
      std::min(static_cast<int>(std::lround(kReach / width_of(phi))), kMostSideways);
  std::vector<double> values;
  for (int t = theta - sideways; t <= theta + sideways; ++t) {
    const int column = (t + kPatchesTheta) % kPatchesTheta;
    for (int p = std::max(0, phi - kReach); p <= std::min(kPatchesPhi - 1, phi + kReach); ++p) {
      values.push_back(patches[column * kPatchesPhi + p]);
    }
  }
  return median(std::move(values));
}

}  // namespace

KeptGains keep_significant(const PatchGains& gains, const std::array<PatchGains, 2>& halves,
                           std::span<const bool> measured) {
  const Eigen::RowVectorXd weights = patch_weights(measured);
  // Root mean square of values less their mean.
  const auto variation_of = [&](const PatchGains& values) {
    const Eigen::RowVector3d mean = weights * values;
    return Eigen::RowVector3d((weights * (values.rowwise() - mean).cwiseAbs2()).cwiseSqrt());
  };
  // Half the difference of the halves: the standard error of their mean.
  const PatchGains difference = 0.5 * (halves[0] - halves[1]);
  const Eigen::RowVector3d whole = weights * gains;
  const double whole_share = kept_share(whole, weights * difference, kWholeModelError);
  const double local_share =
      kept_share(variation_of(gains), variation_of(difference), kLocalModelError);
  KeptGains kept{whole_share * whole, std::nullopt};
  if (local_share > 0.0) kept.patches = local_share * (gains.rowwise() - whole);
  return kept;
}

Eigen::VectorXd without_spots(const Eigen::VectorXd& patches) {
  constexpr double kSpot = 0.1;
  Eigen::VectorXd result = patches;
  for (int patch = 0; patch < kPatches; ++patch) {
    const double usual = median_around(patches, patch / kPatchesPhi, patch % kPatchesPhi);
    if (std::fabs(patches[patch] - usual) > kSpot) result[patch] = usual;
  }
  return result;
}

}  // namespace raywalk::build_lf
