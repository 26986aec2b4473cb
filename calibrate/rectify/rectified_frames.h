// Rectifies the frames of a capture: rotated to world axes and equalised in brightness, in a single
// resampling of the panoramas or, where these were stitched, of the fisheye pictures themselves.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rectify/exposure_gains.h"
#include "calibrate/stitch/fisheye_source.h"

namespace raywalk::calibrate {

// "OUT/rectified/NAME.png" and "OUT/rectified/masks/NAME.png", relative to OUT.
std::filesystem::path rectified_file(const CaptureFrame& frame);
std::filesystem::path rectified_mask_file(const CaptureFrame& frame);

// Writes OUT/rectified: every frame with a pose, rotated by its attitude, its light times its gain;
// where it is masked by `mask` (CV_8UC1 of the panoramas' size in the camera's frame, 0 = masked;
// may be empty) or by a mask of its own, also the two together, rotated alike. With `fisheye`, the
// source of the same frames in the same order, pictures and masks are made from it as panoramas
// are, at their size (stitcher.h); without, from the panoramas. The directory is created under the
// name OUT/rectified.partial and replaces OUT/rectified when complete; an interrupted run with the
// same inputs is resumed. Throws Error naming a file that cannot be read or written, and a frame of
// which a mask leaves nothing; Interrupted.
void write_rectified_frames(const CaptureSet& panoramas, const FramePoses& poses,
                            const std::vector<LightGain>& gains, const cv::Mat& mask,
                            const std::filesystem::path& out,
                            const std::optional<FisheyeSource>& fisheye = std::nullopt);

}  // namespace raywalk::calibrate
