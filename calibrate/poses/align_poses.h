// Aligns solved poses, whose frame and scale are arbitrary, to nominal ones by a similarity.
#pragma once

#include <Eigen/Core>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// x_world = scale * rotation * x_solved + translation_m.
struct PoseAlignment {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_m{0, 0, 0};

  int frames = 0;       // with a solved and a nominal pose
  int scale_pairs = 0;  // pairs of stations that the scale is the median of; 0: the scale is 1
  // Standard deviations of the nominal centres along their principal axes, largest first; and the
  // number of those above zero: 0 a point, 1 a line, 2 a plane, 3 space.
  Eigen::Vector3d spread_m{0, 0, 0};
  int rank = 0;
};

// Scale: the median, over pairs of stations half a line apart, of the ratio of the distance by the
// slider's feedback to the solved one. Only distances on one line are used, as nominal positions of
// different lines are no better than the rails were placed. Rotation: the least-squares rotation
// of solved centres onto nominal ones. Where the centres leave it undetermined (the roll about a
// single line, all of it at a single point), it is the chordal mean of the differences between the
// frames' orientations. Translation: from the mean of the centres. Frames without a nominal pose,
// also those beyond the end of `nominal`, have no part in it. Throws Error if no frame has both
// poses.
PoseAlignment align_poses(const CaptureSet& set, const FramePoses& solved,
                          const FramePoses& nominal);

// Transforms the poses to the world; sigmas of positions are scaled too.
FramePoses aligned(const FramePoses& solved, const PoseAlignment& alignment);

}  // namespace raywalk::calibrate
