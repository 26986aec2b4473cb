// Bundle adjustment of poses, scene points and rails.
#pragma once

#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/point_evidence.h"
#include "calibrate/poses/seen_points.h"
#include "calibrate/rails/fit_rails.h"

namespace raywalk::calibrate {

struct RefinedPoses {
  FramePoses poses{};  // those of the start that observe points; observations and residuals are set
  SeenPoints points{};
  std::vector<double> errors_px{};  // by observation: the angle between predicted and observed
  // Standard deviation of an inlier's error along one axis, robust, panorama 4096 wide.
  double noise_px = 0.0;
  // Observations with smaller errors are inliers and count as a pose's observations.
  double inlier_px = 0.0;
};

// Standard deviations of a weak prior at the initial poses. It only keeps the unobservable common
// frame and scale from drifting.
struct PoseAnchor {
  double position_m = 1.0;
  double rotation_rad = 0.1;
};

// One pose for each panorama, whatever number of faces it was matched in. Observations have a
// Cauchy loss with a scale from their own spread. The stations of a line lie on a rail
// (fit_rails.h), whose parameters are unknowns too, also with a Cauchy loss and their own scatter:
// where the slider's feedback, or a list of positions, contradicts the panoramas, these win.
// `rails` are those of a start that was adjusted before; without them the first pass has none, as
// the nominal poses repeat the rails' positions exactly, and a scatter measured from them would be
// too small. Throws Error if no frame observes a point; Interrupted.
RefinedPoses refine_poses(const CaptureSet& set, const FramePoses& start, const SeenPoints& points,
                          const PoseAnchor& anchor, int threads, std::vector<Rail> rails = {});

}  // namespace raywalk::calibrate
