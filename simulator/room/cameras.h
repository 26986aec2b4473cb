// Camera models as rays of pixels.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/geometry/fisheye_lens.h"
#include "core/geometry/sphere.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {

// World frame (core/geometry/sphere.h), metres.
struct CameraPose {
  Eigen::Vector3d position_m{0, 0, 0};
  Attitude attitude{};
};

// Adds independent normal errors of these standard deviations along each axis and of each angle.
void add_jitter(double position_mm, double attitude_deg, HashRandom random, CameraPose* pose);

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

// An equirectangular panorama.
class PanoramaRays final : public PixelRays {
 public:
  // `eye_radius_m` makes it that of one eye of omnidirectional stereo (EyeCircle): every column is
  // seen from a place of its own on a circle around the camera's position. Throws Error unless the
  // panorama is twice as wide as high.
  explicit PanoramaRays(PanoramaSize size, double eye_radius_m = 0.0);

  int width() const override { return size_.width; }
  int height() const override { return size_.height; }
  double pixel_rad() const override { return kPi / size_.height; }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  PanoramaSize size_;
  EyeCircle eye_;
};

// Whether a pixel of a dual-fisheye frame belongs to the front lens, that is, is nearer to its
// centre.
bool belongs_to_front(const DualFisheyeLayout& layout, PixelPosition pixel);

// A dual-fisheye frame of a 360-degree camera: two image circles, black around them. The pose is
// that of the layout's camera frame.
class DualFisheyeRays final : public PixelRays {
 public:
  // Throws Error unless the image radius of each lens is finite and increases with the angle over
  // its field of view.
  DualFisheyeRays(const DualFisheyeLayout& layout, PanoramaSize frame);

  int width() const override { return frame_.width; }
  int height() const override { return frame_.height; }
  double pixel_rad() const override { return 1.0 / layout_.front.focal_px; }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  // A lens, and the rays of its pixels: (sine of the angle from the axis per radius, its cosine) at
  // equal steps of the squared radius. Solving the lens's polynomial for every ray would take a
  // quarter of the time of a picture. Radii are relative to the focal length.
  struct Lens {
    FisheyeLens lens;
    Eigen::Vector3d position_m;
    Eigen::Matrix3d camera_from_lens;
    double rim_square;
    std::vector<Eigen::Vector2d> rays;
  };

  static Lens tabled(const FisheyeLens& lens, const Eigen::Vector3d& position_m,
                     const Attitude& attitude);

  DualFisheyeLayout layout_;
  PanoramaSize frame_;
  Lens front_;
  Lens back_;
};

}  // namespace raywalk::simulator
