// Bundle adjustment: the poses and scene points that explain best where the points are seen.
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

// So many points that every frame sees about `per_frame` of them, as far as it has so many, those
// with the most observations first: they tie the most poses together for the time they take.
SeenPoints strongest(const SeenPoints& points, int per_frame);

// Width of the Cauchy loss in standard deviations of the residuals: 95 % efficient where they are
// normal (Holland and Welsch 1977).
inline constexpr double kCauchyWidth = 2.385;

struct RefinedPoses {
  FramePoses poses{};  // those of the start that observe points; observations and residuals are set
  SeenPoints points{};
  std::vector<double> errors_px{};  // by observation: bearing_error_px
  // Standard deviation of an inlier's error along one axis, robust, panorama 4096 wide.
  double noise_px = 0.0;
  // Errors beyond count for little; those within inlier_px are a pose's observations.
  double inlier_px = 0.0;
};

// How far poses may lie from where they start, as far as nothing else tells: standard deviations.
// So weak that they only keep what pictures cannot tell, the common frame and its scale, from
// drifting.
struct PoseAnchor {
  double position_m = 1.0;
  double rotation_rad = 0.1;
};

// One pose for each panorama, whatever number of faces it was matched in. Observations have a
// Cauchy loss whose width follows from their own spread, so that a wrong match pulls less the
// farther off it is. Distances between neighbouring stations of a line are tied to the slider's
// feedback within their own spread. Throws Error where no frame observes a point; Interrupted.
RefinedPoses refine_poses(const CaptureSet& set, const FramePoses& start, const SeenPoints& points,
                          const PoseAnchor& anchor, int threads);

// The robust standard deviation along one axis of two-dimensional errors: their median length over
// that of unit noise, sqrt(2 ln 2). 0 for none.
double noise_of(const std::vector<double>& errors_px);

}  // namespace raywalk::calibrate
