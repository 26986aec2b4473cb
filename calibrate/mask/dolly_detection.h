// Detects what moves with the camera: it looks the same from every station of a line, while the
// room moves.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

struct DollyDetection {
  cv::Mat mask{};          // CV_8UC1 of the panoramas' size: 255 valid, 0 masked
  double reach_deg = 0.0;  // largest angle of a masked direction from the nadir
  int lines = 0;           // used: those with at least 8 stations
  int stations = 0;        // used
};

// The mask covers the region connected to the nadir that is static within the noise on all lines,
// plus a margin of 2 degrees. What the frames' own masks hide (frame_masks.h) is not looked at, but
// connects what is around it with the nadir. nullopt if the nadir itself moves as the rest does, or
// is hidden by the frames' masks. Throws Error if
// no line has 8 stations, if the static region reaches 60 degrees from the nadir (a floor without
// texture looks static), and for unreadable frames; Interrupted.
std::optional<DollyDetection> detect_dolly(const CaptureSet& panoramas);

}  // namespace raywalk::calibrate
