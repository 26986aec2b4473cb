// What two lines' panoramas nearest to a crossing show over one another: where they agree the
// picture is grey and sharp, where they do not it has red and cyan edges.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Indices into CaptureSet::frames.
struct CrossingPair {
  int along_x = 0;
  int along_z = 0;
};

// The frames of the two lines that come nearest to one another at the crossing; none where a line
// has no frame with a pose.
std::optional<CrossingPair> nearest_pair(const CaptureSet& set, const LineCrossing& crossing,
                                         const FramePoses& poses);

// A piece of a panorama around the horizon.
struct HorizonWindow {
  int left = 0;  // column; it may wrap at the seam
  int width = 0;
  int top = 0;
  int height = 0;
};

// The ninety degrees with the most structure in `panorama` (CV_8UC3), forty degrees high.
HorizonWindow most_textured_window(const cv::Mat& panorama);

struct Overlay {
  cv::Mat picture{};               // CV_8UC3: the first in red, the second in cyan
  double difference_levels = 0.0;  // root mean square of their grey levels, over the window
};
// Of two CV_8UC3 panoramas of one size.
Overlay overlay_of(const cv::Mat& first, const cv::Mat& second, const HorizonWindow& window);

}  // namespace raywalk::calibrate
