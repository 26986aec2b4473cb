// The difference in brightness of a camera's two lenses, measured where both see the same, once for
// all frames of a capture.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// Light of the back lens as a multiple of the front lens's: blue, green, red.
using ColourGains = std::array<double, 3>;
inline constexpr ColourGains kEqualLenses{1.0, 1.0, 1.0};

struct LensGain {
  ColourGains back_gain = kEqualLenses;
  int frames = 0;  // used
  int points = 0;  // measured in both lenses, of all frames together
  // Of a frame: the median difference of levels between front and back along the seam, without and
  // with the gain, and the correlation of their levels. Medians over the frames; 0 without any.
  double step_before_levels = 0.0;
  double step_after_levels = 0.0;
  double correlation = 0.0;
  std::vector<std::string> warnings{};
};

// Compares at most 24 frames, spread over all lines. With `balance` false the gain stays 1 and only
// the rest is measured. Throws Error as read_frame_pictures does; Interrupted.
LensGain measure_lens_gain(const CaptureSet& set, const DualFisheyeCamera& camera, bool balance);

}  // namespace raywalk::calibrate
