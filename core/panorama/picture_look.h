// What kind of picture a 360-degree camera made, by a cheap look at its pixels.
//
// Cameras can be set to stitch or not, and a picture of the other kind has the same size. The look
// is for warning before hours are spent, so it names a kind only where that is clear.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>

namespace raywalk {

enum class PictureKind {
  kUnclear,     // neither, or too dark, plain, noisy or small to tell
  kPanorama,    // a full equirectangular panorama
  kDualFisheye  // two image circles side by side
};

// `picture` is CV_8UC1 or CV_8UC3 of any size.
//
// A panorama is twice as wide as high; each of its first and last row shows a single point, so that
// they have nearly one colour where rows near the horizon have many; its left and right edges
// continue each other. A dual-fisheye frame is dark around two circles that fill its halves and
// light in them all around. (Both lenses show the same directions where the halves meet, so a step
// there is no sign.)
PictureKind look_at_picture(const cv::Mat& picture);

// The same for an image file in memory, decoded at a fraction of its size. kUnclear if it is none.
PictureKind look_at_picture(std::span<const std::byte> file);

}  // namespace raywalk
