// The similarity that takes solved poses, whose frame and scale are arbitrary, to nominal ones.
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

  int frames = 0;       // with a pose on both sides
  int scale_pairs = 0;  // of stations whose distance on the rail the scale is the median of;
                        // 0: there were none and the scale is 1
  // Of the nominal centres about their mean, as standard deviations along the principal axes,
  // largest first; and how many of them are not zero: 0 a point, 1 a line, 2 a plane, 3 space.
  Eigen::Vector3d spread_m{0, 0, 0};
  int rank = 0;
};

// Scale: the median, over pairs of stations half a line apart, of the distance that the slider's
// feedback tells over the solved one. It is the slider that knows lengths; nominal positions of
// different lines are only as good as the rails were placed. Rotation: the one that best turns
// solved centres onto nominal ones, and where centres leave it open (on one line the rotation about
// that line, at one point all of it) the mean, in the chordal metric, of the differences between
// the frames' orientations. A similarity of centres alone would choose the roll of a line without
// saying so. Translation: from the mean of the centres. Throws Error without a frame that has a
// pose on both sides.
PoseAlignment align_poses(const CaptureSet& set, const FramePoses& solved,
                          const FramePoses& nominal);

// Moves the poses into the world; sigmas of positions are scaled along.
FramePoses aligned(const FramePoses& solved, const PoseAlignment& alignment);

}  // namespace raywalk::calibrate
