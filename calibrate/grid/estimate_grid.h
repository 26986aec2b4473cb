// One estimate of what the rail did: where every line of the grid lies, how it bends and twists,
// and where every panorama on it was taken, from solved poses, the slider's feedback and features
// matched where lines cross.
//
// A line is the rail placed once: an offset, a direction and an attitude of the camera, a bow and a
// twist where the data speaks for them (line_fit.h), and a deviation of each station. A station
// with a pose of its own keeps it, fused with what the rail predicts in inverse proportion to their
// variances; one without gets the prediction, with the stations' scatter as its sigma.
//
// Half of the matches at a crossing take no part in the estimate. They judge it: a result that they
// contradict is reported as not to be trusted.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/grid_result.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

struct GridOptions {
  GridMethod method = GridMethod::kPoses;
  // What is known without solving: nominal_poses of the set, or better. All frames.
  FramePoses start{};
  // CV_8UC1 of the panoramas' size in the camera's frame, 0 where it is not to be used.
  std::optional<cv::Mat> mask{};
  // The lenses the panoramas were stitched from; none: every ray passes through one centre.
  std::optional<DualFisheyeLayout> lenses{};
  // The calibration directory; grid.json and grid.html are written there.
  std::filesystem::path out{};
};

// `solved` is by frame, none where a frame could not be solved; it is not looked at by
// GridMethod::kRotation. The result is in the gauge of the start: the rigid motion that brings the
// positions closest to it (and the attitudes, as far as positions leave a turn open, as those on a
// single line do).
//
// What cannot be trusted is told by GridResult::warnings. Throws Error where there is nothing to
// report on: no line with two solved poses, no crossing for GridMethod::kRotation, a picture that
// cannot be read, an unwritable directory; Interrupted.
GridResult estimate_grid(const CaptureSet& panoramas, const FramePoses& solved,
                         const GridOptions& options);

}  // namespace raywalk::calibrate
