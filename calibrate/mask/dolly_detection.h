// Finds what goes along with the camera: it looks the same from every station of a line, while the
// room moves by.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

struct DollyDetection {
  cv::Mat mask{};          // CV_8UC1 of the panoramas' size: 255 valid, 0 masked
  double reach_deg = 0.0;  // the farthest masked direction from the nadir
  int lines = 0;           // looked at: those of at least 8 stations
  int stations = 0;        // looked at
};

// Around the nadir; what is connected with it and stands still within the noise, all lines
// together, and 2 degrees more. None where what is right under the camera moves as the rest does.
// Throws Error where no line has 8 stations, where what stands still reaches 60 degrees from the
// nadir (a floor without any texture looks as if it moved along), and for unreadable frames;
// Interrupted.
std::optional<DollyDetection> detect_dolly(const CaptureSet& panoramas);

}  // namespace raywalk::calibrate
