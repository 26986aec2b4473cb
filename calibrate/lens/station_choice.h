// Which stations of a capture the lenses are fitted to, and which of them to compare.
#pragma once

#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// About `count` frames, shared among all lines and evenly spread over each; at least five per line
// as far as it has them, and fewer lines, of both axes in turn, where that would be more than
// `count`: lines of one axis alone leave the lens weakly determined in their plane. Indices into
// CaptureSet::frames, line by line.
//
// Evenly over the whole line, not groups of neighbours: what tells about the lens is how features
// move, and they move most over the whole line. Between chosen neighbours they move by less than a
// sixth of the line's length over their distance, which features survive in rooms of any size.
std::vector<int> choose_stations(const CaptureSet& set, int count);

// Two of the chosen stations, as indices into what choose_stations returned.
struct StationPair {
  int first = 0;
  int second = 0;
};

// Neighbours on a line and neighbours but one, and stations of different lines that are no further
// apart than neighbours are.
std::vector<StationPair> pairs_to_match(const CaptureSet& set, const std::vector<int>& stations);

}  // namespace raywalk::calibrate
