#include "calibrate/poses/rail_motion.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "calibrate/base/rotation.h"
#include "core/base/median.h"
#include "core/geometry/listed_axes.h"

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kLeastMotionMatches = 20;
constexpr double kSure = 4.0;       // standard deviations of significant evidence of a pair
constexpr double kMajority = 0.75;  // of the pairs with significant evidence

// Unknowns: the small rotation between the two cameras, then their motion over the mean distance.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// To first order, when the camera moves by t and rotates by w, the bearing b (world axes) of a
// point at the distance rho moves by -(t - (t b) b) / rho - w x b.
struct FlowRow {
  Eigen::Matrix<double, 3, 6> design{};
  Eigen::Vector3d moved{0, 0, 0};
};

FlowRow flow_row(const FramePose& first, const FramePose& second, const BearingMatch& match) {
  const Eigen::Vector3d before = first.world_from_camera * match.in_first;
  const Eigen::Vector3d after = second.world_from_camera * match.in_second;
  FlowRow row;
  row.design.leftCols<3>() = cross_matrix(before);  // -w x b = b x w
  row.design.rightCols<3>() = before * before.transpose() - Eigen::Matrix3d::Identity();
  row.moved = after - before;
  return row;
}

// The mean direction of the lines along an axis; zero if they do not agree or nothing is known.
Eigen::Vector3d common_direction(const CaptureSet& set, std::span<const LineMotion> motions,
                                 LineAxis axis) {
  Eigen::Vector3d sum(0, 0, 0);
  double lines = 0.0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (set.lines[i].axis != axis || motions[i].direction.isZero()) continue;
    sum += motions[i].direction;
    lines += 1.0;
  }
  return lines > 0.0 && sum.norm() > kMajority * lines ? sum.normalized()
                                                       : Eigen::Vector3d(0, 0, 0);
}

}  // namespace

PairMotion pair_motion(const FramePose& first, const FramePose& second,
                       std::span<const BearingMatch> matches) {
  const Eigen::Vector3d planned_m = second.position_m - first.position_m;
  if (matches.size() < kLeastMotionMatches || planned_m.norm() == 0.0) return {};
  std::vector<FlowRow> rows;
  rows.reserve(matches.size());
  for (const BearingMatch& match : matches) rows.push_back(flow_row(first, second, match));
  // Least squares with Cauchy weights, a few iterations: the matches are verified, so few are
  // wrong, but points of all distances are fitted by a single one.
  Vector6 unknown = Vector6::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double spread = 0.0;
  for (int pass = 0; pass < 6; ++pass) {
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    std::vector<double> errors;
    for (const FlowRow& row : rows) {
      const double error = (row.moved - row.design * unknown).norm();
      errors.push_back(error);
      const double weight = spread > 0.0 ? 1.0 / (1.0 + error * error / (spread * spread)) : 1.0;
      normal += weight * row.design.transpose() * row.design;
      right += weight * row.design.transpose() * row.moved;
    }
    const Eigen::LDLT<Matrix6> solver(normal);
    unknown = solver.solve(right);
    spread = std::max(median(errors), 1e-9);
    const Matrix6 inverse = solver.solve(Matrix6::Identity());
    covariance = spread * spread * inverse.bottomRightCorner<3, 3>();
  }
  const Eigen::Vector3d motion = unknown.tail<3>(), planned = planned_m.normalized();
  const double sigma = std::sqrt(std::max(planned.dot(covariance * planned), 0.0));
  const double along = motion.dot(planned) / sigma;
  if (!std::isfinite(along)) return {};
  const bool known = motion.norm() > kSure * std::sqrt(covariance.trace());
  return {along, known ? Eigen::Vector3d(motion.normalized()) : Eigen::Vector3d(0, 0, 0)};
}

LineMotion line_motion(std::span<const PairMotion> pairs) {
  Eigen::Vector3d sum(0, 0, 0);
  double as_planned = 0.0, reversed = 0.0;
  for (const PairMotion& pair : pairs) {
    if (pair.along > kSure) as_planned += 1.0;
    if (pair.along < -kSure) reversed += 1.0;
    sum += pair.direction;
  }
  LineMotion motion;
  if (!sum.isZero()) motion.direction = sum.normalized();
  const double telling = as_planned + reversed;
  if (as_planned > 0.0 && as_planned >= kMajority * telling) motion.along = RailMotion::kAsPlanned;
  if (reversed > 0.0 && reversed >= kMajority * telling) motion.along = RailMotion::kReversed;
  return motion;
}

std::string common_fault(const CaptureSet& set, std::span<const LineMotion> motions) {
  std::array<std::string, 2> moves;
  std::string found;
  for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
    const Eigen::Vector3d direction = common_direction(set, motions, axis);
    if (direction.isZero()) continue;
    std::string& move = moves.at(axis == LineAxis::kX ? 0 : 1);
    move = nearest_axis(direction);
    found += fmt::format("{}those that the list has along {} move along {}",
                         found.empty() ? "" : ", ", axis == LineAxis::kX ? "x" : "z", move);
  }
  const auto& [x, z] = moves;
  // A single line that runs the other way was listed in reverse order.
  if ((x == "-x" && z.empty()) || (x.empty() && z == "-z")) return "";
  const std::string fault = likely_fault_of_axes(x, z);
  return fault.empty() ? "" : fmt::format("by the pictures, {}: {}", found, fault);
}

}  // namespace raywalk::calibrate
