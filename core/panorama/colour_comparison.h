// How the colours of two panoramas taken near to one another differ: by exposure and white balance,
// told apart from what the camera's motion changes.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// Comparisons are best made on panoramas reduced to this width: colours and gross changes need no
// more, and noise averages out.
inline constexpr int kComparisonWidth = 256;
// The motion is followed over windows of this size, in pixels; what travels with the camera holds
// on to it, so that it has to be masked with a margin of half a window.
inline constexpr int kFlowWindow = 15;

// What ratios are of.
enum class ColourScale {
  kLevel,  // 8-bit levels
  kLight   // linear light, by the sRGB curve
};

// Transposed (row = theta, column = phi), in world axes.
struct ComparedPicture {
  cv::Mat colours{};  // CV_8UC3: red, green, blue
  cv::Mat valid{};    // CV_8UC1, 0 = not to be used; empty: all may be
};

struct ColourComparison {
  // Whether enough of both pictures is neither clipped nor black to compare them. The values below
  // are 0 where it is not.
  bool comparable = false;
  // Natural logarithm of the second picture over the first, of the same surface; red, green, blue.
  std::array<double, 3> log_ratio{};
  std::array<double, 3> log_ratio_error{};  // estimated standard error
  // Root mean square difference of the levels, once the second is scaled to the colours of the
  // first: at the same pixel, and of the same surface, where the motion between the two has been
  // followed. The first grows with the baseline; the second only with what motion does not explain.
  double change = 0.0;
  double unexplained_change = 0.0;
};

// Of two pictures of one size.
ColourComparison compare_colours(const ComparedPicture& first, const ComparedPicture& second,
                                 ColourScale scale);

}  // namespace raywalk
