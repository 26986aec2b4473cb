#include "calibrate/grid/split_estimates.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// With fewer samples a half has too large an uncertainty.
constexpr size_t kFewestSamplesPerHalf = 4;

// The variance of a fit's prediction at u, as a multiple of one sample's variance. The `functions`
// Legendre polynomials are orthogonal, so it is the sum of their squares divided by their norms,
// 1 / (2 k + 1), and by the number of samples.
double prediction_variance(int functions, double u, size_t samples) {
  const std::array<double, 4> values{1.0, u, legendre2(u), legendre3(u)};
  double sum = 0.0;
  for (int k = 0; k < functions; ++k) {
    sum += (2.0 * k + 1.0) * std::pow(values[static_cast<size_t>(k)], 2);
  }
  return sum / static_cast<double>(samples);
}

int position_functions(const RailFit& fit) {
  if (fit.kept[P::kSBow]) return 4;
  return fit.kept[P::kBow] ? 3 : 2;
}

int rotation_functions(const RailFit& fit) {
  if (fit.kept[P::kCurvedTwist]) return 3;
  return fit.kept[P::kTwist] ? 2 : 1;
}

struct RailPose {
  Eigen::Vector3d position_m;
  Eigen::Vector3d rotation_rad;
};

RailPose pose_at(const RailFrame& frame, const RailFit& fit, double rail_m) {
  return {rail_position(frame, fit.parameters.data(), rail_m),
          rail_rotation(frame, fit.parameters.data(), rail_m)};
}

// The difference of the two halves of a line, and its expected variances per component.
struct LineDifference {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Vector3d rotation_rad{0, 0, 0};
  double position_variance = 0.0;
  double rotation_variance = 0.0;
};

LineDifference difference_of(const HalfFits& halves, double rail_m) {
  const RailPose one = pose_at(halves.frame, halves.fits[0], rail_m);
  const RailPose two = pose_at(halves.frame, halves.fits[1], rail_m);
  LineDifference difference{one.position_m - two.position_m, one.rotation_rad - two.rotation_rad};
  const double u = halves.frame.u_of(rail_m);
  for (size_t half = 0; half < 2; ++half) {
    const RailFit& fit = halves.fits[half];
    const size_t samples = halves.samples_u[half].size();
    difference.position_variance += std::pow(halves.position_scatter_m, 2) *
                                    prediction_variance(position_functions(fit), u, samples);
    difference.rotation_variance += std::pow(halves.rotation_scatter_rad, 2) *
                                    prediction_variance(rotation_functions(fit), u, samples);
  }
  return difference;
}

}  // namespace

HalfFits fit_halves(const RailFrame& frame, std::span<const RailSample> samples, double spacing_m) {
  HalfFits halves{.frame = frame};
  if (samples.size() < 2 * kFewestSamplesPerHalf) return halves;
  halves.enough = true;
  for (size_t half = 0; half < 2; ++half) {
    std::vector<RailSample> part;
    for (size_t i = half; i < samples.size(); i += 2) part.push_back(samples[i]);
    halves.fits[half] = fit_rail(frame, part, spacing_m);
    for (const RailSample& sample : part) {
      halves.samples_u[half].push_back(frame.u_of(sample.rail_m));
    }
    const RailFit& fit = halves.fits[half];
    halves.position_scatter_m = std::max(
        halves.position_scatter_m, std::hypot(std::max(fit.jitter.along_m, fit.jitter.across_m),
                                              part.front().position_sigma_m));
    halves.rotation_scatter_rad =
        std::max(halves.rotation_scatter_rad,
                 std::hypot(fit.jitter.rotation_rad, part.front().rotation_sigma_rad));
  }
  return halves;
}

SplitDifference split_by_stations(const HalfFits& x, const HalfFits& z, PlanPoint at) {
  if (!x.enough || !z.enough) return {};
  const LineDifference on_x = difference_of(x, at.x_m);
  const LineDifference on_z = difference_of(z, at.z_m);
  return {
      .position_m = (on_x.position_m - on_z.position_m).norm(),
      .position_expected_m = std::sqrt(3.0 * (on_x.position_variance + on_z.position_variance)),
      .rotation_rad = (on_x.rotation_rad - on_z.rotation_rad).norm(),
      .rotation_expected_rad = std::sqrt(3.0 * (on_x.rotation_variance + on_z.rotation_variance))};
}

SplitDifference split_by_matches(const CrossingMatches& crossing, const FramePoses& poses,
                                 const CrossingFitScale& scale) {
  std::array<std::vector<CrossingMatch>, 2> halves;
  for (const CrossingMatch& match : crossing.matches) {
    halves[match.held_out ? 1 : 0].push_back(match);
  }
  const CrossingFit one = fit_crossing(halves[0], poses, scale);
  const CrossingFit two = fit_crossing(halves[1], poses, scale);
  if (one.inliers == 0 || two.inliers == 0) return {};
  const PoseCovariance sum = one.covariance + two.covariance;
  return {.position_m = (one.motion_m - two.motion_m).norm(),
          .position_expected_m = std::sqrt(sum.topLeftCorner<3, 3>().trace()),
          .rotation_rad = (one.rotation_rad - two.rotation_rad).norm(),
          .rotation_expected_rad = std::sqrt(sum.bottomRightCorner<3, 3>().trace())};
}

}  // namespace raywalk::calibrate
