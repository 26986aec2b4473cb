// The frames before the calibration, as a frame list: a room packed of it shows what the
// calibration gains (raywalk-render validate --before).
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Writes OUT/before.csv (file,x,y,z,yaw,pitch,roll[,mask]): the panoramas of poses.csv as they are,
// at their poses in `start`. Only frames with a pose in `poses` are listed, so that both rooms have
// the same stations. Files in OUT are relative to it, others absolute. `mask` (CV_8UC1 of the
// panoramas' size in the camera's frame, 0 = masked; may be empty) is joined with the frames' own
// and written to OUT/before_masks, which is removed where nothing is masked in common. Throws Error
// if a mask cannot be read or a file cannot be written.
void write_before_list(const CaptureSet& panoramas, const FramePoses& start,
                       const FramePoses& poses, const cv::Mat& mask,
                       const std::filesystem::path& out);

}  // namespace raywalk::calibrate
