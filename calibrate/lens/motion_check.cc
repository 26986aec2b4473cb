#include "calibrate/lens/motion_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

// Smaller motions of a feature do not determine the camera's direction of motion.
constexpr double kLeastMove_rad = radians_from_degrees(1.0);
constexpr std::size_t kLeastSeen = 20;
// Largest angle, as a sine, of the motion from a plane that should contain it.
constexpr double kOffPlane = 0.15;
// Share of planes that must agree. Of random matches, a share of kOffPlane agrees with any
// direction.
constexpr double kLeastAgreeing = 0.4;

// Normals of the epipolar planes, all of which contain the motion.
std::vector<Eigen::Vector3d> plane_normals(const std::vector<BearingPair>& seen) {
  std::vector<Eigen::Vector3d> normals;
  for (const BearingPair& one : seen) {
    const Eigen::Vector3d normal = one.before.cross(one.after);
    if (normal.norm() >= std::sin(kLeastMove_rad)) normals.push_back(normal.normalized());
  }
  return normals;
}

// Static points move away from the direction of motion.
bool moves_away_from(const Eigen::Vector3d& direction, const std::vector<BearingPair>& seen) {
  int away = 0;
  for (const BearingPair& one : seen)
    away += (one.after - one.before).dot(direction) < 0.0 ? 1 : -1;
  return away > 0;
}

}  // namespace

std::optional<Eigen::Vector3d> motion_direction(const std::vector<BearingPair>& seen) {
  const std::vector<Eigen::Vector3d> normals = plane_normals(seen);
  if (normals.size() < kLeastSeen) return std::nullopt;
  // RANSAC (Fischler and Bolles 1981): two planes determine the motion; that with the most inliers
  // is taken.
  constexpr int kTries = 400;
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> any(0, normals.size() - 1);
  Eigen::Vector3d best{0, 0, 0};
  std::ptrdiff_t most = 0;
  for (int i = 0; i < kTries; ++i) {
    const Eigen::Vector3d motion = normals[any(random)].cross(normals[any(random)]);
    if (motion.norm() < 0.2) continue;
    const Eigen::Vector3d unit = motion.normalized();
    const auto agreeing = std::count_if(normals.begin(), normals.end(), [&](const auto& normal) {
      return std::fabs(normal.dot(unit)) < kOffPlane;
    });
    if (agreeing > most) {
      most = agreeing;
      best = unit;
    }
  }
  if (static_cast<double>(most) < kLeastAgreeing * static_cast<double>(normals.size())) {
    return std::nullopt;
  }
  return moves_away_from(best, seen) ? best : Eigen::Vector3d(-best);
}

void require_motion_as_planned(const std::vector<MotionComparison>& motions) {
  const double enough = std::cos(radians_from_degrees(45.0));
  int as_planned = 0, reversed = 0;
  double largest_rad = 0.0;
  for (const MotionComparison& motion : motions) {
    const double cosine = std::clamp(motion.planned.dot(motion.seen), -1.0, 1.0);
    if (cosine > enough) ++as_planned;
    if (cosine < -enough) ++reversed;
    largest_rad = std::max(largest_rad, std::acos(cosine));
  }
  const int count = static_cast<int>(motions.size());
  if (as_planned == count) return;
  if (reversed == count) {
    throw Error(
        "the pictures move against the rail: front and back lens are swapped, or the camera looked "
        "backwards; exchange the circles of front and back in the starting lens file");
  }
  if (as_planned + reversed == count) {
    throw Error(
        "the pictures move against the rail along one axis and with it along the other: they are "
        "mirrored, or the camera hung upside down; give pictures that are upright and not flipped");
  }
  throw Error(fmt::format(
      "the pictures move {:.0f} degrees off the rail's direction: the camera was rotated on its "
      "mount, or lines are confused; correct the camera's attitude in the plan",
      degrees_from_radians(largest_rad)));
}

}  // namespace raywalk::calibrate
