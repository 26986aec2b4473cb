// The step `mask`: what goes along with the camera in every frame (dolly, operator) and must not be
// used. A mask is CV_8UC1 of a panorama's size in the camera's own frame: 255 valid, 0 masked.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// Whatever is given adds to what is masked.
struct MaskOptions {
  double cone_deg = 0.0;  // half angle about the nadir, 0 to 89; 0: no cone
  // 8-bit grey panorama, dark (below 128) = masked; one of another size is scaled.
  std::optional<std::filesystem::path> picture{};
  bool automatic = false;       // what goes along with the camera is found in the frames
  std::filesystem::path out{};  // of the calibration
};

// The mask of cone and picture. Throws UsageError for a cone out of range; Error for a picture that
// is unreadable, not grey or not 2:1, and for a mask that leaves under a hundredth of the sphere.
cv::Mat make_mask(PanoramaSize size, const MaskOptions& options);

// make_mask and, where asked for, what detect_dolly (dolly_detection.h) finds; writes
// options.out/mask.png, mask.json and mask.html. None, and what an earlier run wrote
// is removed, where the options ask for no mask or nothing is found. Throws Error as make_mask and
// detect_dolly do, and for frames that are not panoramas.
std::optional<cv::Mat> write_mask(const CaptureSet& panoramas, const MaskOptions& options);

// Share of the sphere that a mask hides, 0..1.
double masked_share(const cv::Mat& mask);

}  // namespace raywalk::calibrate
