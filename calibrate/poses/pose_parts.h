// Divides a grid into parts whose poses are solved one by one, on any machines, and then joined:
// time and memory of a triangulation grow with the number of frames.
#pragma once

#include <span>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/match_pairs.h"

namespace raywalk::calibrate {

// Connected frames that are solved together. All indices are of CaptureSet::frames, ascending.
struct PosePart {
  std::vector<int> home{};  // what the part is made for; every keyframe is of one home
  // Home, all that is matched with it, and the next four keyframes beyond it on every line.
  std::vector<int> frames{};
  std::vector<FramePair> pairs{};  // those of which both frames are in `frames`
};

// Divides the keyframes into the fewest parts of about `most_stations` at home that straight cuts
// across the plan give: each cut is across the longer side, in the middle between two lines, so
// that crossings stay whole, as near as possible to where it divides the keyframes evenly; through
// the middle of the keyframes where there is no such place. What a part does not connect becomes a
// part of its own, or, if it is small, goes to the part that it is matched with most; so do
// held-out frames. The parts depend on nothing but the arguments. One part if there are at most
// `most_stations` (above 0) stations.
std::vector<PosePart> divide_grid(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                  std::span<const int> keyframes, std::span<const FramePair> pairs,
                                  int most_stations);

}  // namespace raywalk::calibrate
