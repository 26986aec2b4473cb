// Bundle adjustment of poses and scene points.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/bearing_residual.h"

namespace raywalk::calibrate {

struct SeenPoints {
  std::vector<Eigen::Vector3d> points_m{};  // world frame
  std::vector<PointObservation> observations{};
};

// Without points that fewer than `least_frames` different panoramas see, and their observations.
SeenPoints widely_seen(const SeenPoints& points, int least_frames);

// A subset of points of which every frame sees about `per_frame`, if it has so many. Points with
// the most observations come first: they constrain the most poses for their computing time.
SeenPoints strongest(const SeenPoints& points, int per_frame);

struct RefinedPoses {
  FramePoses poses{};  // those of the start that observe points; observations and residuals are set
  SeenPoints points{};
  std::vector<double> errors_px{};  // by observation: bearing_error_px
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
// Cauchy loss with a scale from their own spread. Distances between neighbouring stations of a line
// are constrained to the slider's feedback, also within their own spread. Throws Error if no frame
// observes a point; Interrupted.
RefinedPoses refine_poses(const CaptureSet& set, const FramePoses& start, const SeenPoints& points,
                          const PoseAnchor& anchor, int threads);

// The robust standard deviation along one axis of two-dimensional errors: their median length
// divided by that of unit noise, sqrt(2 ln 2). 0 for no errors.
double noise_of(const std::vector<double>& errors_px);

}  // namespace raywalk::calibrate
