#include "core/view/viewport.h"

#include <fmt/format.h>

#include <algorithm>
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

// Range of longitudes and latitudes along the picture's border. Longitudes are unwrapped across
// +-180 degrees; the largest steps between samples bound what lies between them.
struct BorderRange {
  double theta_least = 0.0, theta_most = 0.0, theta_step = 0.0;
  double phi_least = 0.0, phi_most = 0.0, phi_step = 0.0;
};

class BorderWalk {
 public:
  explicit BorderWalk(const Eigen::Matrix3d& world_from_camera) : turn_(world_from_camera) {}

  void visit(const Eigen::Vector3d& ray) {
    const SphereAngles seen = angles_from_direction(turn_ * ray);
    if (first_) {
      theta_ = seen.theta_rad;
      phi_ = seen.phi_rad;
      range_ = {theta_, theta_, 0.0, seen.phi_rad, seen.phi_rad, 0.0};
      first_ = false;
    }
    const double step = wrap_angle(seen.theta_rad - theta_);
    range_.theta_step = std::max(range_.theta_step, std::fabs(step));
    range_.phi_step = std::max(range_.phi_step, std::fabs(seen.phi_rad - phi_));
    theta_ += step;
    phi_ = seen.phi_rad;
    range_.theta_least = std::min(range_.theta_least, theta_);
    range_.theta_most = std::max(range_.theta_most, theta_);
    range_.phi_least = std::min(range_.phi_least, phi_);
    range_.phi_most = std::max(range_.phi_most, phi_);
  }
  const BorderRange& range() const { return range_; }

 private:
  Eigen::Matrix3d turn_;
  bool first_ = true;
  double theta_ = 0.0;
  double phi_ = 0.0;
  BorderRange range_;
};

BorderRange border_range(const Viewport& viewport, const Eigen::Matrix3d& turn) {
  BorderWalk walk(turn);
  const int w = viewport.width;
  const int h = viewport.height;
  constexpr int kSamples = 256;  // per side; more would cost more than the few columns they save
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < kSamples; ++i) {
      const double along = static_cast<double>(side < 2 ? i : kSamples - i) / kSamples;
      const double across = side == 0 || side == 3 ? 0.0 : 1.0;
      walk.visit(side % 2 == 0 ? camera_ray(viewport, along * (w - 1), across * (h - 1))
                               : camera_ray(viewport, across * (w - 1), along * (h - 1)));
    }
  }
  walk.visit(camera_ray(viewport, 0, 0));
  return walk.range();
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
  const BorderRange border = border_range(viewport, turn);
  const double px_per_rad = panorama.width / kTwoPi;
  PanoramaPart part;
  const double phi_margin_px = px_per_rad * border.phi_step + 2.0;
  const double top = (kHalfPi - border.phi_most) * px_per_rad - phi_margin_px;
  const double bottom = (kHalfPi - border.phi_least) * px_per_rad + phi_margin_px;
  part.rows.begin = zenith ? 0 : std::max(0, static_cast<int>(std::floor(top)));
  part.rows.end =
      nadir ? panorama.height : std::min(panorama.height, static_cast<int>(std::ceil(bottom)) + 1);
  const double theta_margin_px = px_per_rad * border.theta_step + 2.0;
  const double left = (border.theta_least + kPi) * px_per_rad - 0.5 - theta_margin_px;
  const double right = (border.theta_most + kPi) * px_per_rad - 0.5 + theta_margin_px;
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
