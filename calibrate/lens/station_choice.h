// Chooses the stations of a capture that the lenses are fitted to, and the pairs to match.
#pragma once

#include <cstddef>
#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// About `count` frames, shared among all lines and evenly spaced on each; at least five per line,
// if it has so many. Where that would be more than `count`, fewer lines are used, alternating
// between the axes: lines of one axis alone leave the lens weakly determined in their plane.
// Indices into CaptureSet::frames, line by line.
//
// The frames are spread over the whole line, not grouped, because the motion of features determines
// the lens and is largest over the whole line. Between chosen neighbours a feature moves by less
// than a sixth of the line's length over its distance, little enough to match in rooms of any size.
std::vector<std::size_t> choose_stations(const CaptureSet& set, std::size_t count);

// Two of the chosen stations, as indices into what choose_stations returned.
struct StationPair {
  std::size_t first = 0;
  std::size_t second = 0;
};

// Pairs of next and second-next stations on a line, and of stations of different lines that are no
// further apart than neighbours.
std::vector<StationPair> pairs_to_match(const CaptureSet& set,
                                        const std::vector<std::size_t>& stations);

}  // namespace raywalk::calibrate
