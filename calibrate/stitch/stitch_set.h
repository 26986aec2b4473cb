// The step `stitch`: the dual-fisheye frames of a capture become panoramas.
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
  // How far the scene is taken to be at; only infinity leaves every half of a panorama exactly as
  // its lens saw it.
  double seam_distance_m = std::numeric_limits<double>::infinity();
  bool balance = true;          // exposure and vignetting of the lenses
  std::filesystem::path out{};  // of the calibration
};

// Writes options.out/panoramas/NAME.png for every frame, stitch.json and stitch.html, and returns
// the set with these files and layout kPanorama; a set of panoramas is returned as it is, and
// nothing is written. Panoramas that are there already are kept where stitch.json says that they
// came of the same frames, camera and options; the others are made anew.
//
// Throws UsageError without a camera and for options out of range; Error for a camera that does not
// fit the frames (proportions, number of files, lenses that leave a gap between them), a frame
// without its back half, an unreadable or damaged picture or one of another size, and a picture
// that is bright where this camera's pictures are dark (a panorama among the frames). Interrupted.
CaptureSet stitch_set(const CaptureSet& set, const std::optional<DualFisheyeCamera>& camera,
                      const StitchOptions& options);

}  // namespace raywalk::calibrate
