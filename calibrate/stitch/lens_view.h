// Projects directions into one of a camera's two lenses.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// The image of a direction in a lens.
struct LensImage {
  PixelPosition pixel{};
  double angle_rad = 0.0;   // from the lens's axis
  double margin_rad = 0.0;  // to the rim of its field of view, at least 0
};

class LensView {
 public:
  // The scene is at `distance_m` from the camera's origin; infinity: no parallax.
  LensView(const FisheyeLens& lens, const Eigen::Matrix3d& camera_from_lens,
           const Eigen::Vector3d& position_m, PanoramaSize picture, double distance_m);

  // The image of a unit direction in the camera's frame; nullopt outside of the field of view or
  // the picture.
  std::optional<LensImage> look(const Eigen::Vector3d& direction) const;

  const FisheyeLens& lens() const { return lens_; }

 private:
  FisheyeLens lens_;
  Eigen::Matrix3d lens_from_camera_;
  Eigen::Vector3d position_m_;
  PanoramaSize picture_;
  double distance_m_;
};

LensView front_view(const DualFisheyeCamera& camera, double distance_m);
LensView back_view(const DualFisheyeCamera& camera, double distance_m);

}  // namespace raywalk::calibrate
