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

namespace raywalk::build_lf {

struct StationGains {
  // [line][station]. The levels of a station times its gain agree with those of the others; the
  // mean over all stations of each channel's logarithm is 0. Stations that no link reaches (all
  // clipped or black) have a gain of 1.
  std::vector<std::vector<ColourGain>> gain;
};

// Solves for the gains from what the links measured. Links that contradict the others, as those of
// a frame with something moving in it do, count little.
StationGains solve_gains(const Grid& grid, std::span<const StationLink> links);

// How the exposure changes from station - 1 of a line to `station`, from the gains of the line: the
// natural logarithm of the factor of the levels, in the channel that changes most.
double log_exposure_step(std::span<const ColourGain> gains, int station);

}  // namespace raywalk::build_lf
