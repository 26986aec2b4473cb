// The frames of a capture in the world's axes and of one brightness, each resampled once.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rectify/exposure_gains.h"

namespace raywalk::calibrate {

// The gains of all frames, from the pictures (exposure_gains.h); reads every frame with a pose.
std::vector<LightGain> measure_gains(const CaptureSet& panoramas, const FramePoses& poses,
                                     const cv::Mat& mask);

// "OUT/rectified/NAME.png" and "OUT/rectified/masks/NAME.png", relative to OUT.
std::filesystem::path rectified_file(const CaptureFrame& frame);
std::filesystem::path rectified_mask_file(const CaptureFrame& frame);

// Writes OUT/rectified: every frame with a pose, turned by its attitude, its light times its gain;
// with a mask (CV_8UC1 of the panoramas' size in the camera's frame, 0 = not to be used; may be
// empty) also the mask turned likewise. The directory appears complete and replaces one that is
// there; what an interrupted run of the same inputs has made in OUT/rectified.partial is kept.
// Throws Error naming a file that cannot be read or written; Interrupted.
void write_rectified_frames(const CaptureSet& panoramas, const FramePoses& poses,
                            const std::vector<LightGain>& gains, const cv::Mat& mask,
                            const std::filesystem::path& out);

}  // namespace raywalk::calibrate
