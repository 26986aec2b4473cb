// The gains that make the frames of a capture equally bright.
//
// A camera's exposure and white balance drift during a capture, even if they were locked. Frames
// taken near each other show the same surfaces, so the ratio of their light measures the change of
// exposure (core/panorama/colour_comparison.h). Frames are linked to their neighbours on the line
// and, where lines cross, to the nearest ones of the other line. The gains are the robust
// least-squares solution of
//   log gain(i) - log gain(j) = log(light in j / light in i)   for every link,
//   log gain(i) = 0                                            weakly,
// channel by channel. The second term keeps the mean brightness as captured.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "core/panorama/colour_comparison.h"

namespace raywalk::calibrate {

// Factors of linear light: red, green, blue; above 0.
using LightGain = std::array<double, 3>;

// Two frames that show the same surfaces; indices into CaptureSet::frames.
struct FrameLink {
  int from = 0;
  int to = 0;
};

// Neighbours on each line (next and next but one) and at crossings the two nearest frames of either
// line. Only frames with a pose.
std::vector<FrameLink> links_of(const CaptureSet& set, const FramePoses& poses);

// A frame reduced for comparison, in world axes. `mask` is CV_8UC1 of the panorama's size in the
// camera's frame, 0 = masked, or empty.
ComparedPicture picture_to_compare(const cv::Mat& panorama, const cv::Mat& mask,
                                   const Eigen::Matrix3d& world_from_camera);

// The measurement of a link: the light in `to` divided by that in `from`.
struct ComparedLink {
  FrameLink link{};
  ColourComparison colours{};
};

// A gain for each of `frames` frames; 1 for frames without links.
std::vector<LightGain> solve_gains(int frames, std::span<const ComparedLink> links);

// Applies a gain of linear light to sRGB levels (0..255), clamped to 255.
class LevelsUnderGain {
 public:
  explicit LevelsUnderGain(const LightGain& gain);
  // In OpenCV's order blue, green, red.
  cv::Vec3f operator()(const cv::Vec3f& levels) const;

 private:
  static constexpr int kStepsPerLevel = 4;
  std::array<std::array<float, 255 * kStepsPerLevel + 2>, 3> table_;
};

}  // namespace raywalk::calibrate
