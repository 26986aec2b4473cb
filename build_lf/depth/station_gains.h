// The gains that make the stations' colours agree.
//
// A camera's exposure and white balance wander while it travels, and may jump. Stations are matched
// by their colours, so these are brought together first.
#pragma once

#include <span>
#include <vector>

#include "build_lf/depth/station_links.h"
#include "build_lf/depth/station_picture.h"
#include "core/geometry/grid.h"

namespace raywalk {

// Where the exposure changes most from one station of a line to the next.
struct ExposureStep {
  StationIndex to;      // the later of the two stations
  double factor = 1.0;  // of its levels over those of the station before, in the channel that
                        // changes most
};

struct StationGains {
  // [line][station]. The levels of a station times its gain agree with those of the others; the
  // mean over all stations of each channel's logarithm is 0.
  std::vector<std::vector<ColourGain>> gain;
  std::vector<ExposureStep> largest_step;  // one per line
  // Stations that no link reaches (all clipped or black): their gain is 1.
  std::vector<StationIndex> unknown;
};

// Solves for the gains from what the links measured. Links that contradict the others, as those of
// a frame with something moving in it do, count little.
StationGains solve_gains(const Grid& grid, std::span<const StationLink> links);

}  // namespace raywalk
