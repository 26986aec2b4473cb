// Fills what is unknown in a picture from what surrounds it, at all scales.
//
// Pull-push (Gortler, Grzeszczuk, Szeliski, Cohen: The Lumigraph, SIGGRAPH 1996, section 3.4): the
// known pixels are averaged into ever coarser pictures; from the coarsest one back, unknown pixels
// are interpolated from the next coarser picture. At every scale they are then relaxed towards the
// mean of their neighbours (Laplace's equation), which removes the steps of the coarse pixels.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

namespace raywalk {

// Whether a picture's last column meets its first.
enum class Seam { kOpen, kJoined };

// `values`: CV_32F, any number of channels. `weights`: CV_32FC1 of the same size, 0 (unknown) to 1
// (known, is kept); a pixel of weight w becomes w of itself and 1 - w of what surrounds it. Values
// of weight 0 are not read. `column_widths`: width of a pixel of each row relative to its height,
// above 0, as the cosine of a panorama's latitudes; empty: 1. Returns false and leaves the picture
// as it is where all of it is unknown.
bool fill_unknown(cv::Mat& values, const cv::Mat& weights, Seam seam,
                  std::span<const float> column_widths = {});

}  // namespace raywalk
