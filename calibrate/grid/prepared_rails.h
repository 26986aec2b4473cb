// The input of the joint estimate: every line fitted to its solved poses, where it has any.
#pragma once

#include <optional>
#include <vector>

#include "calibrate/grid/grid_scale.h"
#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/rail_fit.h"

namespace raywalk::calibrate {

struct PreparedRails {
  std::vector<RailStart> rails{};                  // by line
  std::vector<std::vector<RailSample>> samples{};  // by line, without those rejected
  std::vector<std::optional<RailFit>> fits{};      // by line, nullopt without solved poses
  std::vector<std::vector<int>> rejected{};        // by line, frames
  FramePoses solved{};                             // without those rejected, sigmas set
};

// The stations' scatter assumed where no line has enough solved poses to measure it: 1/25 of the
// stations' spacing (1 mm of 25 mm) and a tenth of a degree, as a rail is built to run straight.
RailJitter assumed_jitter(const GridScale& scale);

// `solved` are in the world. A pose without sigmas gets the smallest plausible ones: a tenth of a
// pixel, and a two-hundredth of the stations' spacing.
PreparedRails prepare_rails(const CaptureSet& set, const FramePoses& solved,
                            const FramePoses& start, const GridScale& scale);

// Initial poses: a station's solved pose, else the prediction of its rail.
FramePoses poses_on_rails(const CaptureSet& set, const std::vector<RailStart>& rails,
                          const FramePoses& solved);

}  // namespace raywalk::calibrate
