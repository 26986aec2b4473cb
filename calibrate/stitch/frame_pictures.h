// Reads a station's pictures for stitching.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/base/capture_set.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// CV_8UC3; the same picture twice for cameras with one file.
struct FramePictures {
  cv::Mat front{};
  cv::Mat back{};
  cv::Mat mask{};  // CV_8UC1 of their size, 0 = masked; empty: nothing is
};

// Throws Error as own_mask (frame_masks.h), and naming the file if it is unreadable or damaged, of
// another size than the camera's pictures, or bright outside of the image circles.
FramePictures read_frame_pictures(const CaptureFrame& frame, const DualFisheyeCamera& camera);

}  // namespace raywalk::calibrate
