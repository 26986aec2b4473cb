// The pairs of frames whose light is compared.
#pragma once

#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Two frames that show the same surfaces; indices into CaptureSet::frames.
struct FrameLink {
  int from = 0;
  int to = 0;
};

// Neighbours on each line (next and next but one) and at crossings the two nearest frames of either
// line. Only frames with a pose.
std::vector<FrameLink> links_of(const CaptureSet& set, const FramePoses& poses);

}  // namespace raywalk::calibrate
