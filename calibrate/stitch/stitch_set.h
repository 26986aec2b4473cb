// The step `stitch`: stitches the dual-fisheye frames of a capture to panoramas.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "calibrate/stitch/stitcher.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct StitchOptions {
  int width = 0;  // of the panoramas, even; 0: default_panorama_width()
  BlendMethod blend = BlendMethod::kMultiBand;
  double blend_deg = kDefaultBlend_deg;  // width of the transition between the lenses
  // Assumed distance of the scene, metres. Only infinity adds no parallax correction to the halves.
  double seam_distance_m = std::numeric_limits<double>::infinity();
  bool balance = true;          // make the light of both lenses equal
  std::filesystem::path out{};  // of the calibration
};

// "panoramas/NAME.png" and "panoramas/masks/NAME.png", relative to OUT.
std::filesystem::path panorama_file(const CaptureFrame& frame);
std::filesystem::path panorama_mask_file(const CaptureFrame& frame);

// Writes OUT/panoramas/NAME.png for every frame, panoramas/masks/NAME.png for those with a
// mask (a lens's masked pixels are taken from the other one where the two are blended), stitch.json
// and its figures, and returns the set with these files and layout kPanorama; a set of panoramas is
// returned unchanged and nothing is written. Existing panoramas are kept if they have the same
// frames, camera and options by stitch.json.
//
// Throws UsageError without a camera and for options out of range; Error for a camera that does not
// fit the frames (aspect ratio, number of files, a gap between the fields of view), a frame without
// its back picture, an unreadable or damaged picture or one of another size, and a picture that is
// bright outside of the image circles (a panorama among the frames). Interrupted.
CaptureSet stitch_set(const CaptureSet& set, const std::optional<DualFisheyeCamera>& camera,
                      const StitchOptions& options);

}  // namespace raywalk::calibrate
