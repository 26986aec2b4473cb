// Reduced lens pictures for measuring light, directions in the overlap of both lenses, and the
// agreement of the lenses there.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "calibrate/stitch/balance_fit.h"
#include "calibrate/stitch/fisheye_source.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// Light is measured as means over patches without clipped pixels.
class LightPicture {
 public:
  // Averages over `shrink` pixels (at least 1) in each direction. `picture` is CV_8UC3; `mask` is
  // CV_8UC1 of its size, 0 = masked, or empty.
  LightPicture(const cv::Mat& picture, const cv::Mat& mask, int shrink);

  // Mean levels (blue, green, red) of the patch around a position of the full picture; nullopt if
  // it reaches beyond the picture or contains pixels that are masked, too dark or too bright.
  std::optional<std::array<double, 3>> levels_at(PixelPosition full) const;

  // CV_8UC1, for tracking features.
  const cv::Mat& grey() const { return grey_; }
  PixelPosition small_from_full(PixelPosition full) const;
  PixelPosition full_from_small(PixelPosition small) const;

 private:
  cv::Size full_;
  cv::Mat levels_;  // CV_32FC3, smoothed
  cv::Mat usable_;  // CV_8UC1
  cv::Mat grey_;
};

// Radius of a patch in pixels of the reduced picture.
inline constexpr double kPatchRadius_px = 5.0;

// ln of light, up to a constant, from a mean level. A change of exposure is an affine function of
// sRGB levels (core/panorama/srgb.h), so it is the same function of their means.
double log_light(double level);

// ln(light of b / light of a) for each colour.
std::array<double, 3> log_light_ratio(const std::array<double, 3>& a,
                                      const std::array<double, 3>& b);

// A direction of the overlap, imaged in both pictures.
struct SeamDirection {
  LensImage front{};
  LensImage back{};
};

// The factor by which pictures are reduced for measuring light, chosen so that a patch covers the
// same angle at any resolution.
int light_shrink(const DualFisheyeCamera& camera);

// Directions spread evenly over the overlap, far enough from the rims for the patches of
// LightPicture; at most a few thousand.
std::vector<SeamDirection> seam_directions(const DualFisheyeCamera& camera);

struct LightPictures {
  LightPicture front;
  LightPicture back;
};
LightPictures light_pictures(const FramePictures& pictures, int shrink);

// Ratios of back to front in every direction where both can be measured.
std::vector<LightRatio> seam_ratios(const LightPictures& pictures,
                                    const std::vector<SeamDirection>& directions);

// The agreement of a frame's two halves along the seam under a balance.
struct SeamFigures {
  double step_levels = 0.0;  // median of front minus back, mean of the colours
  double correlation = 0.0;  // of front and back along the seam
  int directions = 0;        // measured; below 3 the other figures are 0
};
SeamFigures seam_figures(const LightPictures& pictures,
                         const std::vector<SeamDirection>& directions, const LensBalance& balance);

}  // namespace raywalk::calibrate
