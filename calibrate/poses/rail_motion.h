// Checks that the panoramas move as the slider does. If they do not, pictures are mirrored, upside
// down or back to front, or a rail was laid the other way round; bundle adjustment cannot recover
// from that.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// A scene point matched in two panoramas: unit vectors in each camera's frame.
struct BearingMatch {
  Eigen::Vector3d in_first{0, 0, 1};
  Eigen::Vector3d in_second{0, 0, 1};
};

// Evidence, in standard deviations, that bearings moved from one station to another as the poses
// predict: positive if they move against the camera's motion, as static points do, negative if with
// it. Near 0 where the matches do not determine it, as those of distant points.
double motion_evidence(const FramePose& first, const FramePose& second,
                       std::span<const BearingMatch> matches);

enum class RailMotion { kUnknown, kAsPlanned, kReversed };

// The result for a line, from the evidence of its pairs of neighbours.
RailMotion rail_motion(std::span<const double> evidence);

// The likely cause of reversed motions on all lines, and its remedy; empty if all are as planned or
// unknown, or if a single line differs from others. `set` gives the lines' names.
std::string common_fault(const CaptureSet& set, std::span<const RailMotion> motions);

}  // namespace raywalk::calibrate
