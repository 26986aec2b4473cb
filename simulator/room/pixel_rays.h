// Camera models as rays of pixels.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk::capture {

// Subpixel parts per pixel side; a ray passes through the centre of a part.
inline constexpr int kPixelParts = 16;

// A ray in the camera's frame (x right, y up, z forward).
struct CameraRay {
  Eigen::Vector3d origin_m{0, 0, 0};  // differs between lenses
  Eigen::Vector3d direction{0, 0, 1};
};

// A camera model for the renderer. Thread-safe.
class PixelRays {
 public:
  virtual ~PixelRays() = default;

  virtual int width() const = 0;
  virtual int height() const = 0;
  // Angular size of a pixel at the image centre.
  virtual double pixel_rad() const = 0;
  // The ray at part (part_u, part_v) of the image, counted from 0 at the top left across all
  // pixels; empty outside the lens's image.
  virtual std::optional<CameraRay> at_part(int part_u, int part_v) const = 0;
};

// Continuous pixel coordinate (sphere.h) of a part.
inline double position_of_part(int part) { return (part + 0.5) / kPixelParts - 0.5; }

// An equirectangular panorama.
class PanoramaRays final : public PixelRays {
 public:
  explicit PanoramaRays(PanoramaSize size);

  int width() const override { return size_.width; }
  int height() const override { return size_.height; }
  double pixel_rad() const override { return kPi / size_.height; }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  struct SineCosine {
    double sine;
    double cosine;
  };

  PanoramaSize size_;
  std::vector<SineCosine> theta_;  // of every part along u
  std::vector<SineCosine> phi_;    // of every part along v
};

}  // namespace raywalk::capture
