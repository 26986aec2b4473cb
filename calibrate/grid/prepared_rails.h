// Lines made ready for the joint estimate: fitted to their solved poses where they have any.
#pragma once

#include <optional>
#include <vector>

#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/rail_fit.h"

namespace raywalk::calibrate {

struct PreparedRails {
  std::vector<RailStart> rails{};                  // by line
  std::vector<std::vector<RailSample>> samples{};  // by line, without those rejected
  std::vector<std::optional<RailFit>> fits{};      // by line, none without solved poses
  std::vector<std::vector<int>> rejected{};        // by line, frames
  FramePoses solved{};                             // that count, sigmas set
};

// What a rail and its stations are taken to scatter by where no line tells: a rail is a machine
// made to run straight, so little against the distance between stations (1 mm of 25) and a tenth of
// a degree.
RailJitter assumed_jitter(const GridScale& scale);

// `solved` are in the world. A pose without sigmas is given those that a pose from its own picture
// has at the least: a tenth of a pixel, and a two-hundredth of the stations' spacing.
PreparedRails prepare_rails(const CaptureSet& set, const FramePoses& solved,
                            const FramePoses& start, const GridScale& scale);

// Where every station is to begin with: at its solved pose, else as its rail has it.
FramePoses poses_on_rails(const CaptureSet& set, const std::vector<RailStart>& rails,
                          const FramePoses& solved);

}  // namespace raywalk::calibrate
