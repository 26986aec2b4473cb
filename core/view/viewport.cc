#include "core/view/viewport.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// Angles of many turns lose their fractions of a degree.
constexpr double kMaxTurns = 100.0;

// Direction of a pixel position in the camera frame, not normalised; (0, 0) is the centre of the
// top left pixel.
Eigen::Vector3d camera_ray(const Viewport& viewport, double column, double row) {
  const double f = focal_length_px(viewport);
  return {(column + 0.5 - 0.5 * viewport.width) / f, -(row + 0.5 - 0.5 * viewport.height) / f, 1.0};
}

// Whether the picture, enlarged by a pixel on every side, contains a direction of the camera frame.
bool holds(const Viewport& viewport, const Eigen::Vector3d& direction) {
  if (direction.z() <= 0.0) return false;
  const double f = focal_length_px(viewport);
  return std::fabs(direction.x() / direction.z()) * f <= 0.5 * viewport.width + 1.0 &&
         std::fabs(direction.y() / direction.z()) * f <= 0.5 * viewport.height + 1.0;
}

// A range of angles along the picture's border, and their largest step between samples, which
// bounds what lies between them.
struct BorderRange {
  double least = 0.0, most = 0.0, step = 0.0;

  void add(double angle, double before) {
    least = std::min(least, angle);
    most = std::max(most, angle);
    step = std::max(step, std::fabs(angle - before));
  }
};
struct BorderRanges {
  BorderRange theta{}, phi{};  // longitudes are unwrapped across +-180 degrees
};

BorderRanges border_ranges(const Viewport& viewport, const Eigen::Matrix3d& turn) {
  constexpr int kSamples = 256;  // per side; more would cost more than the few columns they save
  const double right = viewport.width - 1, bottom = viewport.height - 1;
  const std::array<std::array<double, 2>, 5> corners{
      {{0.0, 0.0}, {right, 0.0}, {right, bottom}, {0.0, bottom}, {0.0, 0.0}}};
  SphereAngles before = angles_from_direction(turn * camera_ray(viewport, 0.0, 0.0));
  BorderRanges ranges{{before.theta_rad, before.theta_rad}, {before.phi_rad, before.phi_rad}};
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 1; i <= kSamples; ++i) {
      const double along = static_cast<double>(i) / kSamples;
      SphereAngles at = angles_from_direction(
          turn * camera_ray(viewport, std::lerp(corners[side][0], corners[side + 1][0], along),
                            std::lerp(corners[side][1], corners[side + 1][1], along)));
      at.theta_rad = before.theta_rad + wrap_angle(at.theta_rad - before.theta_rad);
      ranges.theta.add(at.theta_rad, before.theta_rad);
      ranges.phi.add(at.phi_rad, before.phi_rad);
      before = at;
    }
  }
  return ranges;
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

PanoramaPart part_shown(const Viewport& viewport, PanoramaSize panorama) {
  const Eigen::Matrix3d turn = world_from_camera(viewport.attitude);
  // Latitude has no extremum inside a region without a pole, so the border has both; around a pole
  // all longitudes occur.
  const bool zenith = holds(viewport, turn.transpose() * Eigen::Vector3d(0.0, 1.0, 0.0));
  const bool nadir = holds(viewport, turn.transpose() * Eigen::Vector3d(0.0, -1.0, 0.0));
  const auto [theta, phi] = border_ranges(viewport, turn);
  const double px_per_rad = panorama.width / kTwoPi;
  PanoramaPart part;
  const double phi_margin_px = px_per_rad * phi.step + 2.0;
  const double top = (kHalfPi - phi.most) * px_per_rad - phi_margin_px;
  const double bottom = (kHalfPi - phi.least) * px_per_rad + phi_margin_px;
  part.rows.begin = zenith ? 0 : std::max(0, static_cast<int>(std::floor(top)));
  part.rows.end =
      nadir ? panorama.height : std::min(panorama.height, static_cast<int>(std::ceil(bottom)) + 1);
  const double theta_margin_px = px_per_rad * theta.step + 2.0;
  const double left = (theta.least + kPi) * px_per_rad - 0.5 - theta_margin_px;
  const double right = (theta.most + kPi) * px_per_rad - 0.5 + theta_margin_px;
  if (zenith || nadir || right - left + 2.0 >= panorama.width) {
    part.columns = panorama.width;
    return part;
  }
  const auto first = static_cast<int>(std::floor(left));
  part.columns = static_cast<int>(std::ceil(right)) - first + 1;
  part.first_column = wrapped_column(first, panorama.width);
  return part;
}

}  // namespace raywalk
