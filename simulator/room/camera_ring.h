// Several cameras on a ring around a station, whose pictures are stitched to one panorama as if
// everything were infinitely far: near things jump at the seams, and each camera has an exposure of
// its own.
//
// Camera i of n looks horizontally outwards at longitude 2 pi i / n of the rig's frame and covers
// the longitudes within pi / n of its own, up to the zenith and down to the nadir.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "simulator/room/pixel_rays.h"
#include "simulator/room/room_settings.h"

namespace raywalk::capture {

// Which camera sees a longitude, and which one beyond the nearer seam.
struct RingCameras {
  int own = 0;
  int other = 0;
  // Weight of the other in a feathered seam, 0 to 0.5; 0 outside of it.
  double other_weight = 0.0;
};
RingCameras ring_cameras(const RingSettings& ring, double theta_rad);

// The rays of each longitude's own camera, or of the other one where its weight is not 0.
class RingRays final : public PixelRays {
 public:
  enum class Camera { kOwn, kOther };

  RingRays(const RingSettings& ring, PanoramaSize size, Camera camera);

  int width() const override { return panorama_.width(); }
  int height() const override { return panorama_.height(); }
  double pixel_rad() const override { return panorama_.pixel_rad(); }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  PanoramaRays panorama_;
  std::vector<std::optional<Eigen::Vector3d>> origins_m_;  // of every part along u
};

// The exposure of each camera at station `moment`, relative: that of the camera times that of the
// camera at this station, normally distributed around 1, clamped to a factor of 4 and determined by
// the seed.
std::vector<double> ring_gains(const RingSettings& ring, int seed, int moment);

// For apply_sensor: the light of each pixel of a picture by RingRays, from gains and vignetting.
// CV_32FC1.
cv::Mat ring_light(const RingSettings& ring, const std::vector<double>& gains, PanoramaSize size,
                   RingRays::Camera camera);

// Blends the pictures of the own and the other cameras (CV_8UC3), in levels, as stitchers do.
cv::Mat stitched(const RingSettings& ring, const cv::Mat& own, const cv::Mat& other);

}  // namespace raywalk::capture
