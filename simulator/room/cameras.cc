#include "simulator/room/cameras.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

// Continuous pixel coordinate (sphere.h) of a part.
double position_of_part(int part) { return (part + 0.5) / kPixelParts - 0.5; }

double squared_distance(PixelPosition a, PixelPosition b) {
  return (a.u - b.u) * (a.u - b.u) + (a.v - b.v) * (a.v - b.v);
}

}  // namespace

void add_jitter(double position_mm, double attitude_deg, HashRandom random, CameraPose* pose) {
  for (int axis = 0; axis < 3; ++axis) {
    pose->position_m[axis] += 1e-3 * position_mm * random.normal();
  }
  const double spread_rad = radians_from_degrees(attitude_deg);
  pose->attitude.yaw_rad += spread_rad * random.normal();
  pose->attitude.pitch_rad += spread_rad * random.normal();
  pose->attitude.roll_rad += spread_rad * random.normal();
}

PanoramaRays::PanoramaRays(PanoramaSize size, double eye_radius_m)
    : size_(size), eye_{{0, 0, 0}, eye_radius_m} {
  if (size.height < 1 || size.width != 2 * size.height) {
    throw Error("a panorama of the virtual room must be twice as wide as high");
  }
}

std::optional<CameraRay> PanoramaRays::at_part(int part_u, int part_v) const {
  const PixelPosition pixel{position_of_part(part_u), position_of_part(part_v)};
  const SphereAngles angles = angles_from_pixel(pixel, size_);
  return CameraRay{eye_.position_m(angles.theta_rad), direction_from_angles(angles)};
}

bool belongs_to_front(const DualFisheyeLayout& layout, PixelPosition pixel) {
  return squared_distance(pixel, layout.front.centre) <=
         squared_distance(pixel, layout.back.centre);
}

DualFisheyeRays::DualFisheyeRays(const DualFisheyeLayout& layout, PanoramaSize frame)
    : layout_(layout),
      frame_(frame),
      front_(tabled(layout.front, layout.front_position_m, {})),
      back_(tabled(layout.back, layout.back_position_m, layout.back_attitude)) {}

DualFisheyeRays::Lens DualFisheyeRays::tabled(const FisheyeLens& lens,
                                              const Eigen::Vector3d& position_m,
                                              const Attitude& attitude) {
  // Steps so small that linear interpolation is exact to 1e-8, a hundred-thousandth of a pixel.
  constexpr int kSteps = 16384;
  require_monotonic_radius(lens);
  const double rim_rad = (1.0 - 1e-12) * lens.largest_angle_rad;
  const PixelPosition rim = *project(lens, {std::sin(rim_rad), 0.0, std::cos(rim_rad)});
  const double rim_radius = (rim.u - lens.centre.u) / lens.focal_px;
  Lens made{lens, position_m, world_from_camera(attitude), rim_radius * rim_radius, {}};
  made.rays.reserve(kSteps + 1);
  for (int i = 0; i <= kSteps; ++i) {
    const double radius = rim_radius * std::sqrt(std::max(i, 1) / static_cast<double>(kSteps));
    // A little inside of the rim, where rounding cannot take it outside.
    const double u = lens.centre.u + (1.0 - 1e-12) * radius * lens.focal_px;
    const Eigen::Vector3d direction = *unproject(lens, {u, lens.centre.v});
    made.rays.emplace_back(direction.x() / radius, direction.z());
  }
  // On the axis, where the first would be 0 / 0, both are linear to the next two steps.
  made.rays[0] = 2.0 * made.rays[1] - made.rays[2];
  return made;
}

std::optional<CameraRay> DualFisheyeRays::at_part(int part_u, int part_v) const {
  const PixelPosition pixel{position_of_part(part_u), position_of_part(part_v)};
  const Lens& from = belongs_to_front(layout_, pixel) ? front_ : back_;
  const double right = (pixel.u - from.lens.centre.u) / from.lens.focal_px;
  const double up = (from.lens.centre.v - pixel.v) / from.lens.focal_px;
  const double square = right * right + up * up;
  if (square > from.rim_square) return std::nullopt;
  const auto last = from.rays.size() - 2;
  const double at = square / from.rim_square * static_cast<double>(last + 1);
  const auto step = std::min(static_cast<std::size_t>(at), last);
  const double share = at - static_cast<double>(step);
  const Eigen::Vector2d ray = (1.0 - share) * from.rays[step] + share * from.rays[step + 1];
  const Eigen::Vector3d direction(ray.x() * right, ray.x() * up, ray.y());
  return CameraRay{from.position_m, from.camera_from_lens * direction};
}

}  // namespace raywalk::simulator
