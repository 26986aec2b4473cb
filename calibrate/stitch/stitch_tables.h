// Projection of directions into the lenses of a camera, and the lookup tables of stitching: the
// lens and the source position of every pixel of a panorama.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/files/lens_file.h"
#include "core/geometry/sphere.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {

enum class BlendMethod {
  kMultiBand,  // OpenCV's multi-band blender: wide for coarse structure, narrow for fine
  kFeather,    // one linear ramp: faster
};

// Wide enough to hide residual differences in brightness, narrow enough to limit ghosting by the
// parallax between the lenses.
inline constexpr double kDefaultBlend_deg = 2.0;

struct StitcherOptions {
  BlendMethod blend = BlendMethod::kMultiBand;
  double blend_deg = kDefaultBlend_deg;  // above 0 and at most 30
  // Assumed distance of the scene; see StitchOptions.
  double seam_distance_m = std::numeric_limits<double>::infinity();
};

// The factor for shifted sRGB levels (core/panorama/srgb.h) that undoes a factor of light.
inline double root_of_light(double factor) { return std::pow(factor, -1.0 / kSrgbExponent); }

// The image of a direction in a lens.
struct LensImage {
  PixelPosition pixel{};
  double margin_rad = 0.0;  // to the rim of its field of view, at least 0
  double root = 1.0;        // root_of_light of the lens's falloff there
};

class LensView {
 public:
  // Of the front or the back lens. The scene is at `distance_m` from the camera's origin; infinity:
  // no parallax. Keeps a reference to the camera.
  LensView(const DualFisheyeCamera& camera, bool back, double distance_m);

  // The image of a unit direction in the camera's frame; nullopt outside of the field of view or
  // the picture.
  std::optional<LensImage> look(const Eigen::Vector3d& direction) const;

  const FisheyeLens& lens() const { return lens_; }

 private:
  const DualFisheyeCamera& camera_;
  const FisheyeLens& lens_;
  Eigen::Matrix3d lens_from_camera_;
  Eigen::Vector3d position_m_;
  double distance_m_;
};

// What the pixels of a panorama are read from in one lens, where its region includes the lens.
struct LensSamples {
  cv::Mat positions{};  // CV_32FC2: right and down in the lens's picture, pixels; 0 elsewhere
  cv::Mat roots{};      // CV_32FC1: LensImage::root; 1 elsewhere
};

// Which lenses a pixel of the panorama is read from.
inline constexpr unsigned char kFrontOnly = 0;
inline constexpr unsigned char kBackOnly = 1;
inline constexpr unsigned char kBothLenses = 2;

struct StitchTables {
  PanoramaSize size{};
  LensSamples front{};
  LensSamples back{};
  cv::Mat region{};        // CV_8UC1, one of the three above
  cv::Mat front_weight{};  // CV_32FC1, 0..1: a ramp across the seam; 0.5 on it
};

// The panorama is in the axes that `world_from_camera` turns the camera's into; the identity: in
// the camera's own. The seam is at equal angles from the rims of both lenses. Throws Error if some
// direction is seen by neither lens.
StitchTables make_stitch_tables(const DualFisheyeCamera& camera, PanoramaSize size,
                                const StitcherOptions& options,
                                const Eigen::Matrix3d& world_from_camera);

}  // namespace raywalk::calibrate
