// The rays of one eye of omnidirectional stereo, whose place differs between the columns.
#pragma once

#include <vector>

#include "simulator/room/pixel_rays.h"

namespace raywalk::capture {

class EyeRays final : public PixelRays {
 public:
  // `eye_radius_m` as EyeCircle has it, around the camera's position.
  EyeRays(PanoramaSize size, double eye_radius_m);

  int width() const override { return panorama_.width(); }
  int height() const override { return panorama_.height(); }
  double pixel_rad() const override { return panorama_.pixel_rad(); }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  PanoramaRays panorama_;
  std::vector<Eigen::Vector3d> origins_m_;  // of every part along u
};

}  // namespace raywalk::capture
