// Flat pictures, resampled from the part of a panorama that they show.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/view/view_options.h"
#include "core/view/viewport.h"

namespace raywalk {

// The rays of a picture's pixels in world axes, of any length: of the first one, and the steps to
// the next one to the right and below.
struct FlatRays {
  Eigen::Vector3d first, right, down;
};
FlatRays flat_rays(const Viewport& viewport);

// A picture that is wanted.
struct FlatPicture {
  Viewport viewport;
  cv::Mat* image;
};

// Resamples a picture of viewport.height x viewport.width from a rendered part of a panorama.
void resample_flat(const cv::Mat& rendered, const PanoramaPart& part, PanoramaSize panorama,
                   const Viewport& viewport, Interpolation interpolation, cv::Mat* image);

// How many times larger, to a side, a picture is resampled and then averaged down because it is
// much coarser than the panorama.
int flat_supersampling(const Viewport& viewport, PanoramaSize panorama);

}  // namespace raywalk
