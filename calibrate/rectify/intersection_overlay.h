// Red-cyan overlays of the two lines' panoramas nearest to an intersection: grey and sharp where
// they agree, with red and cyan edges where they do not.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Indices into CaptureSet::frames.
struct IntersectionPair {
  int along_x = 0;
  int along_z = 0;
};

// The frames of the two lines that are nearest to each other at the intersection; nullopt if a line
// has no frame with a pose.
std::optional<IntersectionPair> nearest_pair(const CaptureSet& set,
                                             const LineIntersection& intersection,
                                             const FramePoses& poses);

// A window of a panorama around the horizon.
struct HorizonWindow {
  int left = 0;  // column; it may wrap at the seam
  int width = 0;
  int top = 0;
  int height = 0;
};

// The window, 90 degrees wide and 40 high, with the most texture in `panorama` (CV_8UC3), where
// `valid` (CV_8UC1 of its size, 0 = masked; empty: everywhere) allows.
HorizonWindow most_textured_window(const cv::Mat& panorama, const cv::Mat& valid = cv::Mat());

struct Overlay {
  cv::Mat picture{};  // CV_8UC3: the first in red, the second in cyan
  // Root mean square of their grey levels, over what is valid in the window; NaN if nothing is.
  double difference_levels = 0.0;
};
// Of two CV_8UC3 panoramas of one size; `valid` as above, of both.
Overlay overlay_of(const cv::Mat& first, const cv::Mat& second, const HorizonWindow& window,
                   const cv::Mat& valid = cv::Mat());

}  // namespace raywalk::calibrate
