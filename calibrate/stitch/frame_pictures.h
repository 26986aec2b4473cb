// A station's pictures as they are read for stitching.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/base/capture_set.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// CV_8UC3; the same picture twice for cameras that give one file.
struct FramePictures {
  cv::Mat front{};
  cv::Mat back{};
};

// Throws Error naming the file: unreadable or damaged, of another size than the camera's pictures,
// or bright where the camera's pictures are dark.
FramePictures read_frame_pictures(const CaptureFrame& frame, const DualFisheyeCamera& camera);

}  // namespace raywalk::calibrate
