// What a station captured, as a picture that views can be compared with.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/room/room.h"

namespace raywalk {

// The pixels of a panorama that are compared: every `stride`-th column and row (at least 1).
struct SampledPixels {
  PanoramaSize panorama;
  int stride = 1;

  // The panorama's column or row of the i-th one sampled.
  int at(int i) const { return stride / 2 + i * stride; }
  int columns() const { return count(panorama.width); }
  int rows() const { return count(panorama.height); }

 private:
  int count(int pixels) const { return (pixels - stride / 2 + stride - 1) / stride; }
};

// The sampled pixels as captured, without gains: CV_8UC3, red, green, blue; a row of the result is
// a column of the panorama, from the zenith down.
cv::Mat captured_columns(const LineVolume& volume, int station, const SampledPixels& pixels);

// Which of them are valid: CV_8UC1 of the same layout, 0 = masked, else 255.
cv::Mat valid_columns(const LineVolume& volume, int station, const SampledPixels& pixels);

// The whole panorama as a picture: CV_8UC3, BGR.
cv::Mat captured_picture(const LineVolume& volume, int station);

// Its mask: CV_8UC1, 0 = masked, else 255; empty where no station of the line has a mask.
cv::Mat captured_mask(const LineVolume& volume, int station);

}  // namespace raywalk
