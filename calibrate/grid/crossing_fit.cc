#include "calibrate/grid/crossing_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "calibrate/base/rotation.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr int kFewestMatches = 8;

struct RayPair {
  WorldRay x{};
  WorldRay z{};
};

std::vector<RayPair> ray_pairs(std::span<const CrossingMatch> matches, const FramePoses& poses) {
  std::vector<RayPair> pairs;
  pairs.reserve(matches.size());
  for (const CrossingMatch& match : matches) {
    pairs.push_back({world_ray(*poses[static_cast<size_t>(match.frame_x)], match.ray_x),
                     world_ray(*poses[static_cast<size_t>(match.frame_z)], match.ray_z)});
  }
  return pairs;
}

WorldRay moved(const WorldRay& ray, const CrossingFit& fit) {
  const Eigen::Matrix3d rotation = matrix_of(fit.rotation_rad);
  return {fit.pivot_m + rotation * (ray.origin_m - fit.pivot_m) + fit.motion_m,
          rotation * ray.direction};
}

// The rotation of the x rays that most matches agree on, with a tolerance for parallax: RANSAC over
// pairs of matches (Fischler and Bolles 1981), then the mean over the inliers.
Eigen::Vector3d rotation_of_most(std::span<const RayPair> pairs) {
  constexpr int kTrials = 400;
  const double tolerance_cos = std::cos(radians_from_degrees(3.0));
  std::minstd_rand random(1);
  std::uniform_int_distribution<size_t> any(0, pairs.size() - 1);
  const auto sum_over = [&](const auto& counts) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const RayPair& pair : pairs) {
      if (counts(pair)) sum += pair.z.direction * pair.x.direction.transpose();
    }
    return sum;
  };
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  std::ptrdiff_t most = -1;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RayPair& one = pairs[any(random)];
    const RayPair& two = pairs[any(random)];
    if (one.x.direction.cross(two.x.direction).norm() < 0.1) continue;
    const Eigen::Matrix3d rotation =
        nearest_rotation(one.z.direction * one.x.direction.transpose() +
                         two.z.direction * two.x.direction.transpose());
    const std::ptrdiff_t agree =
        std::count_if(pairs.begin(), pairs.end(), [&](const RayPair& pair) {
          return (rotation * pair.x.direction).dot(pair.z.direction) > tolerance_cos;
        });
    if (agree > most) {
      most = agree;
      best = rotation;
    }
  }
  return vector_of(nearest_rotation(sum_over([&](const RayPair& pair) {
    return (best * pair.x.direction).dot(pair.z.direction) > tolerance_cos;
  })));
}

// Order of the unknowns: motion, a small rotation on top of the current one, mean inverse distance.
using Unknowns = Eigen::Matrix<double, 7, 1>;
using NormalMatrix = Eigen::Matrix<double, 7, 7>;

struct NormalEquations {
  NormalMatrix matrix = NormalMatrix::Zero();
  Unknowns right = Unknowns::Zero();

  // `value` is a whitened residual, `gradient` its derivative.
  void add(const Unknowns& gradient, double value, double weight) {
    matrix.selfadjointView<Eigen::Lower>().rankUpdate(gradient, weight);
    right -= weight * value * gradient;
  }
  NormalMatrix full() const { return matrix.selfadjointView<Eigen::Lower>(); }
};

// The weight of the Cauchy loss in iteratively reweighted least squares.
double cauchy_weight(double square) {
  constexpr double kScale = 2.0;
  return 1.0 / (1.0 + square / (kScale * kScale));
}

// With v = d + w c, c = a - b, and q = v / |v| (match_residual.h), where the x ray has the
// direction d and the origin a = pivot + l + motion:
//   dv = w d(motion) - ([d]x + w [l]x) d(turn) + c dw,   dq = (I - q q^T) dv / |v|.
void add_match(const RayPair& pair, const Whitening& whitening, const CrossingFit& fit,
               const Eigen::Matrix3d& rotation, NormalEquations* equations) {
  const Eigen::Vector3d direction = rotation * pair.x.direction;
  const Eigen::Vector3d lever = rotation * (pair.x.origin_m - fit.pivot_m);
  const Eigen::Vector3d baseline = fit.pivot_m + lever + fit.motion_m - pair.z.origin_m;
  const double w = fit.depth.mean;
  const Eigen::Vector3d v = direction + w * baseline;
  const Eigen::Vector3d q = v.normalized();
  Eigen::Matrix<double, 3, 7> change;
  change << w * Eigen::Matrix3d::Identity(), -cross_matrix(direction) - w * cross_matrix(lever),
      baseline;
  const Whitening onto = whitening * (Eigen::Matrix3d::Identity() - q * q.transpose()) / v.norm();
  const Eigen::Matrix<double, 2, 7> gradients = onto * change;
  const Eigen::Vector2d residual = whitening * (q - pair.z.direction);
  const double weight = cauchy_weight(residual.squaredNorm());
  equations->add(gradients.row(0).transpose(), residual[0], weight);
  equations->add(gradients.row(1).transpose(), residual[1], weight);
}

void add_priors(const CrossingFitScale& scale, const CrossingFit& fit, NormalEquations* equations) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    equations->add(Unknowns::Unit(i) / scale.motion_m, fit.motion_m[i] / scale.motion_m, 1.0);
  }
  const MeanDepthPrior assumed = mean_depth_prior(scale.scene_m);
  equations->add(Unknowns::Unit(6) / assumed.sigma, (fit.depth.mean - assumed.mean) / assumed.sigma,
                 1.0);
}

NormalEquations equations_at(std::span<const RayPair> pairs, std::span<const Whitening> whitenings,
                             const CrossingFitScale& scale, const CrossingFit& fit) {
  NormalEquations equations;
  const Eigen::Matrix3d rotation = matrix_of(fit.rotation_rad);
  for (size_t i = 0; i < pairs.size(); ++i) {
    add_match(pairs[i], whitenings[i], fit, rotation, &equations);
  }
  add_priors(scale, fit, &equations);
  return equations;
}

// Gauss-Newton steps of iteratively reweighted least squares, with the whitening fixed at the
// current motion. Also sets the covariance.
void improve(std::span<const RayPair> pairs, const CrossingFitScale& scale, double noise_rad,
             CrossingFit* fit) {
  std::vector<Whitening> whitenings;
  whitenings.reserve(pairs.size());
  for (const RayPair& pair : pairs) {
    whitenings.push_back(whitening_of(moved(pair.x, *fit), pair.z, fit->depth, noise_rad));
  }
  constexpr int kMostSteps = 12;
  constexpr double kConverged = 1e-4;  // standard deviations
  for (int step = 0; step < kMostSteps; ++step) {
    const NormalEquations equations = equations_at(pairs, whitenings, scale, *fit);
    const NormalMatrix normal = equations.full();
    const Eigen::LDLT<NormalMatrix> factors(normal);
    const Unknowns change = factors.solve(equations.right);
    fit->motion_m += change.head<3>();
    fit->rotation_rad = vector_of(matrix_of(change.segment<3>(3)) * matrix_of(fit->rotation_rad));
    fit->depth.mean += change[6];
    // A feature has a match with each station of the other line. Its error is the same in all of
    // them, so together they count as one.
    fit->covariance =
        kCrossingStations * factors.solve(NormalMatrix::Identity()).topLeftCorner<6, 6>();
    if (change.dot(normal * change) < kConverged * kConverged) break;
  }
}

// The residuals of one direction along (in inverse distances) and across the epipolar line.
struct Split {
  double across_rad = 0.0;
  double along_rad = 0.0;  // beyond the mean depth
  double per_inverse_distance =
      0.0;  // derivative of along_rad by inverse distance, radians per 1/m
};

Split split_of(const RayPair& pair, const CrossingFit& fit) {
  const WorldRay x = moved(pair.x, fit);
  const Whitening unit = whitening_of(x, pair.z, {fit.depth.mean, 0.0}, std::sqrt(0.5));
  const Eigen::Vector2d difference =
      unit * direction_difference<double>(x.origin_m, x.direction, pair.z.origin_m,
                                          pair.z.direction, fit.depth.mean);
  const Eigen::Vector3d baseline = x.origin_m - pair.z.origin_m;
  return {difference[1], difference[0], pair.z.direction.cross(baseline).norm()};
}

// From the inliers' distances across their epipolar lines.
double noise_of(std::span<const RayPair> pairs, const CrossingFit& fit, double least_rad) {
  std::vector<double> across;
  across.reserve(pairs.size());
  for (const RayPair& pair : pairs) across.push_back(std::fabs(split_of(pair, fit).across_rad));
  constexpr int kRounds = 3;
  constexpr double kInlierSigmas = 4.0;
  double sigma = std::max(std::sqrt(2.0) * least_rad, robust_sigma(across));
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> good;
    std::copy_if(across.begin(), across.end(), std::back_inserter(good),
                 [&](double value) { return value <= kInlierSigmas * sigma; });
    sigma = std::max(std::sqrt(2.0) * least_rad, robust_sigma(std::move(good)));
  }
  return sigma / std::sqrt(2.0);
}

// The standard deviation of the scene's inverse distances, from matches with a sufficient baseline;
// unchanged if there are too few.
double depth_sigma_of(std::span<const RayPair> pairs, const CrossingFit& fit) {
  std::vector<double> off;
  for (const RayPair& pair : pairs) {
    const Split split = split_of(pair, fit);
    if (split.per_inverse_distance * fit.depth.sigma < 4.0 * fit.noise_rad) continue;
    if (std::fabs(split.across_rad) > 4.0 * fit.noise_rad) continue;
    off.push_back(std::fabs(split.along_rad / split.per_inverse_distance));
  }
  if (off.size() < kFewestMatches) return fit.depth.sigma;
  // Distances have longer tails than a normal distribution.
  return std::max(1.5 * robust_sigma(std::move(off)), 0.1 * std::fabs(fit.depth.mean));
}

void mark_inliers(std::span<const RayPair> pairs, CrossingFit* fit) {
  constexpr double kInlierSigmas = 4.0;
  fit->inlier.assign(pairs.size(), false);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Split split = split_of(pairs[i], *fit);
    const double noise = std::sqrt(2.0) * fit->noise_rad;
    const double along = std::hypot(noise, fit->depth.sigma * split.per_inverse_distance);
    fit->inlier[i] = std::fabs(split.across_rad) < kInlierSigmas * noise &&
                     std::fabs(split.along_rad) < kInlierSigmas * along;
  }
  fit->inliers = static_cast<int>(std::count(fit->inlier.begin(), fit->inlier.end(), true));
}

// An evenly spaced subset of the pairs, for approximate steps.
std::vector<RayPair> sample_of(std::span<const RayPair> pairs) {
  constexpr size_t kEnough = 500;
  const size_t count = std::min(pairs.size(), kEnough);
  std::vector<RayPair> sample;
  sample.reserve(count);
  for (size_t i = 0; i < count; ++i) sample.push_back(pairs[i * pairs.size() / count]);
  return sample;
}

Eigen::Vector3d mean_origin(std::span<const RayPair> pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const RayPair& pair : pairs) sum += pair.x.origin_m;
  return sum / static_cast<double>(pairs.size());
}

}  // namespace

WorldRay world_ray(const FramePose& pose, const MatchRay& ray) {
  return {pose.position_m + pose.world_from_camera * ray.origin_m,
          pose.world_from_camera * ray.bearing};
}

double epipolar_error_rad(const CrossingMatch& match, const FramePoses& poses,
                          const CrossingFit& fit) {
  const RayPair pair = ray_pairs({&match, 1}, poses).front();
  return std::fabs(split_of(pair, fit).across_rad) / std::sqrt(2.0);
}

CrossingFitScale fit_scale(const GridScale& scale) {
  return {.scene_m = scale.length_m,
          .motion_m = std::max(2.0 * scale.spacing_m, 0.1 * scale.length_m),
          .pixel_rad = scale.pixel_rad};
}

CrossingFit fit_crossing(std::span<const CrossingMatch> matches, const FramePoses& poses,
                         const CrossingFitScale& scale) {
  CrossingFit fit;
  const MeanDepthPrior assumed = mean_depth_prior(scale.scene_m);
  fit.depth = {assumed.mean, assumed.sigma};
  fit.inlier.assign(matches.size(), false);
  if (matches.size() < kFewestMatches) return fit;
  const std::vector<RayPair> pairs = ray_pairs(matches, poses);
  fit.pivot_m = mean_origin(pairs);
  const std::vector<RayPair> some = sample_of(pairs);
  fit.rotation_rad = rotation_of_most(some);
  // From coarse to fine, so that most matches contribute even if the start is far off.
  for (const double noise_deg : {2.0, 0.7, 0.25}) {
    for (int i = 0; i < 2; ++i) improve(some, scale, radians_from_degrees(noise_deg), &fit);
  }
  constexpr int kFineRounds = 4;
  const double least_rad = 1e-3 * scale.pixel_rad;
  for (int i = 0; i < kFineRounds; ++i) {
    fit.noise_rad = noise_of(pairs, fit, least_rad);
    fit.depth.sigma = depth_sigma_of(pairs, fit);
    improve(pairs, scale, fit.noise_rad, &fit);
  }
  mark_inliers(pairs, &fit);
  return fit;
}

}  // namespace raywalk::calibrate
