// Colour differences between two panoramas taken near each other: exposure and white balance,
// separated from changes due to the camera's motion.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace raywalk::build_lf {

// The recommended panorama width for comparisons: enough for colours and gross changes, and
// averages out noise.
inline constexpr int kComparisonWidth = 256;
// Window of the optical flow, in pixels. Objects that move with the camera disturb the flow of any
// window that touches them, so mask them with a margin of half a window.
inline constexpr int kFlowWindow = 15;

// Transposed (row = theta, column = phi), in world axes.
struct ComparedPicture {
  cv::Mat colours{};  // CV_8UC3: red, green, blue
  cv::Mat valid{};    // CV_8UC1, 0 = invalid; empty: all valid
};

struct ColourComparison {
  // Whether enough pixels of both pictures are neither clipped nor black. If not, the values below
  // are 0.
  bool comparable = false;
  // Natural logarithm of the ratio of 8-bit levels, second / first, for the same surface; red,
  // green, blue.
  std::array<double, 3> log_ratio{};
  // Root mean square difference in levels after scaling the second picture to the colours of the
  // first. `change` compares equal pixels and grows with the baseline; `unexplained_change`
  // compares equal surfaces, found by optical flow, after scaling them to equal means within some
  // 6 degrees, so only changes other than motion and exposure count.
  double change = 0.0;
  double unexplained_change = 0.0;
};

// Compares two pictures of equal size.
ColourComparison compare_colours(const ComparedPicture& first, const ComparedPicture& second);

}  // namespace raywalk::build_lf
