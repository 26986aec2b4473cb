#include "calibrate/stitch/lens_view.h"

#include <cmath>

namespace raywalk::calibrate {
namespace {

// Pixels extend half a pixel beyond their centres.
bool is_within(PixelPosition pixel, PanoramaSize picture) {
  return pixel.u >= -0.5 && pixel.v >= -0.5 && pixel.u <= picture.width - 0.5 &&
         pixel.v <= picture.height - 0.5;
}

}  // namespace

LensView::LensView(const FisheyeLens& lens, const Eigen::Matrix3d& camera_from_lens,
                   const Eigen::Vector3d& position_m, PanoramaSize picture, double distance_m)
    : lens_(lens),
      lens_from_camera_(camera_from_lens.transpose()),
      position_m_(position_m),
      picture_(picture),
      distance_m_(distance_m) {}

std::optional<LensImage> LensView::look(const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d seen =
      lens_from_camera_ *
      (std::isinf(distance_m_) ? direction : distance_m_ * direction - position_m_);
  const auto pixel = project(lens_, seen);
  if (!pixel || !is_within(*pixel, picture_)) return std::nullopt;
  const double angle = std::atan2(std::hypot(seen.x(), seen.y()), seen.z());
  return LensImage{*pixel, angle, lens_.largest_angle_rad - angle};
}

LensView front_view(const DualFisheyeCamera& camera, double distance_m) {
  return {camera.layout.front, Eigen::Matrix3d::Identity(), camera.layout.front_position_m,
          camera.picture, distance_m};
}

LensView back_view(const DualFisheyeCamera& camera, double distance_m) {
  return {camera.layout.back, world_from_camera(camera.layout.back_attitude),
          camera.layout.back_position_m, camera.picture, distance_m};
}

}  // namespace raywalk::calibrate
