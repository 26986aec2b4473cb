// Compares the light of the frames of a capture.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rectify/exposure_gains.h"

namespace raywalk::calibrate {

// Indices of the frames with a pose, ascending.
std::vector<int> posed_frames(const FramePoses& poses);

// Compares neighbours on a line, the frames nearest to a crossing, and held-out frames with the
// stations nearest to them, all with a pose; `mask` is that of all frames, or empty. The exposures
// of held-out frames are relative to the stations', which they have no part in. Throws Error for
// files that cannot be read; Interrupted.
ExposureResult compare_light(const CaptureSet& panoramas, const FramePoses& poses,
                             const cv::Mat& mask);

}  // namespace raywalk::calibrate
