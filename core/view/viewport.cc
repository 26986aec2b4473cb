#include "core/view/viewport.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// Angles of many turns lose their fractions of a degree.
constexpr double kMaxTurns = 100.0;

// Whether the picture, enlarged by a pixel on every side, contains a direction of the camera frame.
bool holds(const Viewport& viewport, const Eigen::Vector3d& direction) {
  if (direction.z() <= 0.0) return false;
  const double f = focal_length_px(viewport);
  return std::fabs(direction.x() / direction.z()) * f <= 0.5 * viewport.width + 1.0 &&
         std::fabs(direction.y() / direction.z()) * f <= 0.5 * viewport.height + 1.0;
}

// The directions of the corner pixels, in order around the picture.
std::array<Eigen::Vector3d, 4> corner_rays(const Viewport& viewport, const Eigen::Matrix3d& turn) {
  const double f = focal_length_px(viewport);
  const double right = 0.5 * (viewport.width - 1) / f, top = 0.5 * (viewport.height - 1) / f;
  return {turn * Eigen::Vector3d(-right, top, 1.0), turn * Eigen::Vector3d(right, top, 1.0),
          turn * Eigen::Vector3d(right, -top, 1.0), turn * Eigen::Vector3d(-right, -top, 1.0)};
}

}  // namespace

void require_viewport(const Viewport& viewport) {
  const double fov_deg = degrees_from_radians(viewport.fov_x_rad);
  if (!(fov_deg > 0.0 && fov_deg <= kMaxFovDeg * (1.0 + 1e-12))) {
    throw UsageError(fmt::format(
        "the field of view is {:g} degrees; it must be above 0, at most {}", fov_deg, kMaxFovDeg));
  }
  const auto is_side = [](int side) { return side >= 1 && side <= kMaxViewport_px; };
  if (!is_side(viewport.width) || !is_side(viewport.height)) {
    throw UsageError(fmt::format("a picture of {} x {} pixels is not possible; sides are 1 to {}",
                                 viewport.width, viewport.height, kMaxViewport_px));
  }
  const Attitude& turn = viewport.attitude;
  for (const double angle_rad : {turn.yaw_rad, turn.pitch_rad, turn.roll_rad}) {
    if (std::abs(angle_rad) <= kMaxTurns * kTwoPi) continue;
    throw UsageError(
        fmt::format("yaw, pitch and roll must be numbers of degrees from {0:g} to {1:g}, not {2:g}",
                    -360.0 * kMaxTurns, 360.0 * kMaxTurns, degrees_from_radians(angle_rad)));
  }
}

double focal_length_px(const Viewport& viewport) {
  return 0.5 * viewport.width / std::tan(0.5 * viewport.fov_x_rad);
}

// In a picture without a pole, meridians are straight lines that meet outside, so that the extremes
// of longitude lie in corners, and those of latitude on the border. A side of the border is part of
// a great circle, whose extremes are the directions in its plane nearest to the poles.
PanoramaPart part_shown(const Viewport& viewport, PanoramaSize panorama) {
  constexpr double kMargin = 3.0;  // pixels: what cubic samples reach, and rounding
  const Eigen::Matrix3d turn = world_from_camera(viewport.attitude);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  const double middle_rad = angles_from_direction(turn.col(2)).theta_rad;
  double left_rad = 0.0, right_rad = 0.0;  // from the middle
  double lowest_rad = kHalfPi, highest_rad = -kHalfPi;
  const auto add_latitude = [&](const Eigen::Vector3d& ray) {
    const double phi_rad = angles_from_direction(ray).phi_rad;
    lowest_rad = std::min(lowest_rad, phi_rad);
    highest_rad = std::max(highest_rad, phi_rad);
  };
  const auto corners = corner_rays(viewport, turn);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d &from = corners[i], &to = corners[(i + 1) % corners.size()];
    add_latitude(from);
    const double theta_rad = wrap_angle(angles_from_direction(from).theta_rad - middle_rad);
    left_rad = std::min(left_rad, theta_rad);
    right_rad = std::max(right_rad, theta_rad);
    const Eigen::Vector3d normal = from.cross(to);
    if (normal.squaredNorm() == 0.0) continue;  // a single pixel
    const Eigen::Vector3d highest = up - up.dot(normal) / normal.squaredNorm() * normal;
    for (const Eigen::Vector3d& extreme : {highest, Eigen::Vector3d(-highest)}) {
      const bool on_side =
          from.cross(extreme).dot(normal) > 0.0 && extreme.cross(to).dot(normal) > 0.0;
      if (on_side) add_latitude(extreme);
    }
  }
  const bool zenith = holds(viewport, turn.transpose() * up);
  const bool nadir = holds(viewport, turn.transpose() * -up);
  const double px_per_rad = panorama.width / kTwoPi;
  PanoramaPart part;
  const double top = (kHalfPi - highest_rad) * px_per_rad - 0.5 - kMargin;
  const double bottom = (kHalfPi - lowest_rad) * px_per_rad - 0.5 + kMargin;
  part.rows.begin = zenith ? 0 : std::max(0, static_cast<int>(std::floor(top)));
  part.rows.end =
      nadir ? panorama.height : std::min(panorama.height, static_cast<int>(std::ceil(bottom)) + 1);
  const double middle = (middle_rad + kPi) * px_per_rad - 0.5;
  const auto first = static_cast<int>(std::floor(middle + left_rad * px_per_rad - kMargin));
  part.columns = static_cast<int>(std::ceil(middle + right_rad * px_per_rad + kMargin)) - first + 1;
  part.first_column = wrapped_column(first, panorama.width);
  if (zenith || nadir || part.columns >= panorama.width) {
    part.columns = panorama.width;
    part.first_column = 0;
  }
  return part;
}

}  // namespace raywalk
