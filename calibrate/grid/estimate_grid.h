// Estimates the position, direction, bow and twist of every line of the grid, and the pose of every
// panorama on it, from solved poses, the slider's feedback and features matched where lines cross.
//
// A line is one placement of the rail: an offset, a direction and an attitude of the camera, a bow
// and a twist where the data support them (rail_fit.h), and a deviation of each station. The pose
// of a station with a solved pose is that pose fused with the rail's prediction, weighted by
// inverse variance. A station without one gets the prediction, with the stations' scatter as its
// sigma. Held-out frames have no part in the estimate; those with a solved pose get that pose,
// corrected as the stations near it (held_out_poses.h).
//
// Half of the matches at a crossing are held out of the estimate and used to check it: a result
// that they contradict is reported as not trustworthy.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/grid_result.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

struct GridOptions {
  GridMethod method = GridMethod::kPoses;
  // Initial poses by frame. A frame without one starts at its nominal pose.
  FramePoses start{};
  // Of all frames: CV_8UC1 of the panoramas' size in the camera's frame, 0 = masked. Masks of
  // single frames (frame_masks.h) are honoured as well.
  std::optional<cv::Mat> mask{};
  // The lenses the panoramas were stitched from; nullopt: one centre of projection for all rays.
  std::optional<DualFisheyeLayout> lenses{};
  // The calibration directory; grid.json is written there.
  std::filesystem::path out{};
};

// `solved` is by frame, nullopt where a frame could not be solved; GridMethod::kRotation ignores
// it. The gauge is that of the start: the result is rigidly aligned to the start's positions, and
// to its attitudes where the positions leave a rotation undetermined (a single line).
//
// GridResult::warnings lists why a result is not trustworthy. Throws Error where no result is
// possible: no line with two solved poses, no crossing for GridMethod::kRotation, an unreadable
// picture, an unwritable directory; Interrupted.
GridResult estimate_grid(const CaptureSet& panoramas, const FramePoses& solved,
                         const GridOptions& options);

// The estimate from given matches, with its checks and warnings. `start` has a pose for every
// frame; `crossings` are those of the set, and one without matches gets a warning. Throws Error as
// estimate_grid does.
GridResult estimate_from_matches(const CaptureSet& set, GridMethod method, const FramePoses& solved,
                                 const FramePoses& start,
                                 const std::vector<CrossingMatches>& crossings);

}  // namespace raywalk::calibrate
