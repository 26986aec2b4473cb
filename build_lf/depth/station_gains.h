// Colour gains of the stations (exposure and white balance compensation).
//
// A camera's exposure and white balance drift along a line and may jump. Matching compares colours,
// so these are equalised first.
#pragma once

#include <span>
#include <vector>

#include "build_lf/depth/station_links.h"
#include "core/geometry/grid.h"
#include "core/panorama/gain_field.h"

namespace raywalk::build_lf {

struct StationGains {
  // [line][station], factors of the 8-bit levels. The mean logarithm over all stations is 0 in each
  // channel. Stations without a link (all clipped or black) have a gain of 1.
  std::vector<std::vector<ColourGain>> gain;
};

// The same as fields without local factors.
std::vector<std::vector<GainField>> whole_fields(const StationGains& gains);

// Solves for the gains from the links' log ratios. Robust to outliers, such as links of a frame
// with moving objects.
StationGains solve_gains(const Grid& grid, std::span<const StationLink> links);

// The change of exposure from station - 1 of a line to `station`: the natural logarithm of the
// factor of the levels, in the channel that changes most. `gains` are those of the line.
double log_exposure_step(std::span<const ColourGain> gains, int station);

}  // namespace raywalk::build_lf
