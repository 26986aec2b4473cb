#include "calibrate/poses/rail_motion.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "calibrate/base/rotation.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kLeastMotionMatches = 20;
constexpr double kSure = 4.0;       // standard deviations of significant evidence of a pair
constexpr double kMajority = 0.75;  // of the pairs with significant evidence

// Unknowns: three of the small rotation between the two cameras, one of the mean inverse distance.
using Vector4 = Eigen::Vector4d;

// To first order, when the camera moves by t and rotates by w, the bearing b (world axes) of a
// point at the distance rho moves by -(t - (t b) b) / rho - w x b.
struct FlowRow {
  Eigen::Matrix<double, 3, 4> design{};
  Eigen::Vector3d moved{0, 0, 0};
};

FlowRow flow_row(const FramePose& first, const FramePose& second, const Eigen::Vector3d& along,
                 const BearingMatch& match) {
  const Eigen::Vector3d before = first.world_from_camera * match.in_first;
  const Eigen::Vector3d after = second.world_from_camera * match.in_second;
  FlowRow row;
  row.design.leftCols<3>() = cross_matrix(before);  // -w x b = b x w
  row.design.col(3) = -(along - along.dot(before) * before);
  row.moved = after - before;
  return row;
}

}  // namespace

double motion_evidence(const FramePose& first, const FramePose& second,
                       std::span<const BearingMatch> matches) {
  const Eigen::Vector3d motion = second.position_m - first.position_m;
  if (matches.size() < kLeastMotionMatches || motion.norm() == 0.0) return 0.0;
  std::vector<FlowRow> rows;
  for (const BearingMatch& match : matches) {
    rows.push_back(flow_row(first, second, motion.normalized(), match));
  }
  // Least squares with Cauchy weights, a few iterations: the matches are verified, so few are
  // wrong, but points of all distances are fitted by a single one.
  Vector4 unknown = Vector4::Zero();
  double sigma = 0.0;
  double spread = 0.0;
  for (int pass = 0; pass < 6; ++pass) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Vector4 right = Vector4::Zero();
    std::vector<double> errors;
    for (const FlowRow& row : rows) {
      const double error = (row.moved - row.design * unknown).norm();
      errors.push_back(error);
      const double weight = spread > 0.0 ? 1.0 / (1.0 + error * error / (spread * spread)) : 1.0;
      normal += weight * row.design.transpose() * row.design;
      right += weight * row.design.transpose() * row.moved;
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(normal);
    unknown = solver.solve(right);
    spread = std::max(median(errors), 1e-9);
    sigma = spread * std::sqrt(std::max(solver.solve(Vector4::Unit(3))[3], 0.0));
  }
  const double evidence = unknown[3] / sigma;
  return std::isfinite(evidence) ? evidence : 0.0;
}

RailMotion rail_motion(std::span<const double> evidence) {
  const auto as_planned =
      std::count_if(evidence.begin(), evidence.end(), [](double value) { return value > kSure; });
  const auto reversed =
      std::count_if(evidence.begin(), evidence.end(), [](double value) { return value < -kSure; });
  const double telling = static_cast<double>(as_planned + reversed);
  if (as_planned > 0 && static_cast<double>(as_planned) >= kMajority * telling) {
    return RailMotion::kAsPlanned;
  }
  if (reversed > 0 && static_cast<double>(reversed) >= kMajority * telling) {
    return RailMotion::kReversed;
  }
  return RailMotion::kUnknown;
}

std::string common_fault(const CaptureSet& set, std::span<const RailMotion> motions) {
  // Number of lines by axis that run as planned and that are reversed.
  std::array<int, 2> as_planned{};
  std::array<int, 2> reversed{};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const std::size_t axis = set.lines[i].axis == LineAxis::kX ? 0 : 1;
    if (motions[i] == RailMotion::kAsPlanned) ++as_planned[axis];
    if (motions[i] == RailMotion::kReversed) ++reversed[axis];
  }
  const auto [x_planned, z_planned] = as_planned;
  const auto [x_reversed, z_reversed] = reversed;
  if (x_reversed + z_reversed == 0) return "";
  if (x_planned == 0 && x_reversed > 0 && z_planned > 0 && z_reversed == 0) {
    return "along x the pictures move against the slider, along z with it: the camera is mirrored "
           "left to right or hung upside down; mirror the pictures back, or give the attitude "
           "(roll 180)";
  }
  if (x_planned + z_planned == 0 && x_reversed > 0 && z_reversed > 0) {
    return "on all lines the pictures move against the slider: the camera looks backwards, or "
           "every rail runs the other way; give the attitude (yaw 180), or correct the positions";
  }
  if (z_planned == 0 && z_reversed > 0 && x_planned > 0 && x_reversed == 0) {
    return "along z the pictures move against the slider, along x with it: the camera is mirrored "
           "and looks backwards; mirror the pictures back, or correct the positions";
  }
  return "";
}

}  // namespace raywalk::calibrate
