// Rectifies the frames of a capture of fisheye pictures: panoramas in world axes, in a single
// resampling of the pictures that they were stitched from. Captured panoramas need none: lists give
// their attitudes.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/stitch/stitch_record.h"

namespace raywalk::calibrate {

// "OUT/rectified/NAME.png" and "OUT/rectified/masks/NAME.png", relative to OUT.
std::filesystem::path rectified_file(const CaptureFrame& frame);
std::filesystem::path rectified_mask_file(const CaptureFrame& frame);

// Writes OUT/rectified: every frame with a pose, made from the pictures of `fisheye` as panoramas
// are (stitcher.h), at their size, rotated by its attitude; where it is masked by `mask` (CV_8UC1
// of the panoramas' size in the camera's frame, 0 = masked; may be empty) or by a mask of its own,
// also the two together, rotated alike. `panoramas` are the same frames in the same order. The
// directory is created under the name OUT/rectified.partial and replaces OUT/rectified when
// complete; an interrupted run with the same inputs is resumed. Throws Error naming a file that
// cannot be read or written, and a frame of which a mask leaves nothing; Interrupted.
void write_rectified_frames(const FisheyeSource& fisheye, const CaptureSet& panoramas,
                            const FramePoses& poses, const cv::Mat& mask,
                            const std::filesystem::path& out);

}  // namespace raywalk::calibrate
