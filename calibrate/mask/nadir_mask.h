// The step `mask`: hides what moves with the camera (dolly, operator). A mask is CV_8UC1 of a
// panorama's size in the camera's own frame: 255 valid, 0 masked.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// The mask is the union of all given parts.
struct MaskOptions {
  double cone_deg = 0.0;  // half angle of a cone about the nadir, 0 to 89; 0 disables it
  // 8-bit grey panorama, dark (below 128) = masked; one of another size is scaled.
  std::optional<std::filesystem::path> picture{};
  bool automatic = false;       // detect what moves with the camera (dolly_detection.h)
  std::filesystem::path out{};  // of the calibration
};

// The mask of cone and picture. Throws UsageError for a cone out of range; Error for a picture that
// is unreadable, not grey or not 2:1, and for a mask that leaves under a hundredth of the sphere.
cv::Mat make_mask(PanoramaSize size, const MaskOptions& options);

// The mask common to all frames: the union of make_mask and, if enabled, detect_dolly. Masks of
// single frames (frame_masks.h) stay what they are; every step joins the two. Writes
// options.out/mask.png, mask.json and its figure. If the options define no mask or nothing is
// detected, returns nullopt, writes no mask.png, and mask.json and the figure only if frames have
// masks of their own; files of an earlier run are removed. Throws Error as make_mask, detect_dolly
// and joint_mask do, and for frames that are not panoramas.
std::optional<cv::Mat> write_mask(const CaptureSet& panoramas, const MaskOptions& options);

}  // namespace raywalk::calibrate
