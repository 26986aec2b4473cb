// Fills what is unknown in a picture from what surrounds it, at all scales.
//
// Pull-push (Gortler, Grzeszczuk, Szeliski, Cohen: The Lumigraph, SIGGRAPH 1996, section 3.4): the
// known pixels are averaged into ever coarser pictures; from the coarsest one back, unknown pixels
// are interpolated from the next coarser picture. At every scale they are then relaxed towards the
// mean of their neighbours (Laplace's equation), which removes the steps of the coarse pixels.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// Whether a picture's last column meets its first.
enum class Seam { kOpen, kJoined };

// Rows of a panorama that a picture shows.
struct ShownRows {
  int first = 0;  // the picture's first one
  int panorama_height = 0;
};

// `values`: CV_32F, any number of channels; not read where `unknown` (of the same size) is not 0.
// Returns false and leaves the picture as it is where all of it is unknown.
bool fill_unknown(const cv::Mat1b& unknown, Seam seam, ShownRows rows, cv::Mat* values);

}  // namespace raywalk
