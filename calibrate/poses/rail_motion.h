// Does what the panoramas show move as the slider says the camera did? Where it does not, pictures
// are mirrored, upside down or back to front, or a rail was laid the other way round; no bundle
// adjustment finds its way out of that.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// The same thing seen in two panoramas: unit vectors in each camera's frame.
struct BearingMatch {
  Eigen::Vector3d in_first{0, 0, 1};
  Eigen::Vector3d in_second{0, 0, 1};
};

// How bearings moved from one station to another against how they should: positive when they flow
// against the camera's motion, as standing things do; the larger, the surer (standard deviations).
// 0 where the matches do not tell, as far things do not.
double motion_evidence(const FramePose& first, const FramePose& second,
                       std::span<const BearingMatch> matches);

enum class RailMotion { kUnknown, kAsPlanned, kReversed };

// The verdict of all pairs of neighbours on a line.
RailMotion rail_motion(std::span<const double> evidence);

// What the verdicts of all lines together mean, in words with what to do; empty where all is as
// planned or unknown, or where a single line stands against others. With `set` for the lines'
// names.
std::string common_fault(const CaptureSet& set, std::span<const RailMotion> motions);

}  // namespace raywalk::calibrate
