// Lookup tables of stitching: the lens and the source position of every pixel of a panorama.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "calibrate/stitch/fisheye_kernels.h"
#include "calibrate/stitch/lens_balance.h"
#include "core/files/lens_file.h"
#include "core/geometry/sphere.h"

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

// Consecutive pixels of a panorama's row that are read from one lens.
struct SampleRun {
  int row = 0;
  int column = 0;
  int count = 0;
  std::size_t first = 0;  // index into LensSamples::samples
};

struct LensSamples {
  std::vector<SampleRun> runs{};
  std::vector<FisheyeSample> samples{};
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
                                const StitcherOptions& options, const LensBalance& balance,
                                const Eigen::Matrix3d& world_from_camera);

}  // namespace raywalk::calibrate
