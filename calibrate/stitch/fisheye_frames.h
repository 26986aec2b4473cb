// The fisheye pictures of a capture's frames, checked against the camera.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "calibrate/base/capture_set.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// The camera at the size of a set's pictures. Throws UsageError without a camera; Error naming the
// station whose number of files is not the camera's, or for another aspect ratio.
DualFisheyeCamera fitting_camera(const CaptureSet& set,
                                 const std::optional<DualFisheyeCamera>& camera);

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
