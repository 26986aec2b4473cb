// Chooses the stations to solve and the pairs of panoramas to match: neighbours on a rail and
// stations around intersections. Exhaustive matching would take hours and add nothing.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// The reference length of a capture: the side of a cell, as the median distance of neighbouring
// intersections along the lines. If no line has two intersections, it is two thirds of the longest
// line, as lines reach beyond their cell. Metres, above 0 unless all stations of all lines
// coincide.
double cell_side_m(const CaptureSet& set, std::span<const LineIntersection> intersections);

// Indices of frames in ascending order: on every line, stations at most `keyframes_mm` apart where
// the line is dense enough, with the first, the last and the two around each intersection. 0
// selects all. Held-out frames are always among them, as no rail predicts them.
std::vector<std::size_t> choose_keyframes(const CaptureSet& set,
                                          std::span<const LineIntersection> intersections,
                                          double keyframes_mm);

// Indices of two frames, first < second.
using FramePair = std::pair<std::size_t, std::size_t>;

// Along a line: each keyframe with the next and the 4th, 16th, … after it within a quarter of the
// cell's side (near pairs make long tracks, far ones limit drift); where the 4th is further, with
// the two next; so also from one placement of the rail to the next on its line. Across: at every
// intersection, five keyframes of each line, spread over a fifth of the cell's side on both sides
// of it, all pairs. Held-out frames: each with keyframes of the two lines nearest to it, the two
// around it and five spread likewise. Sorted, without duplicates.
std::vector<FramePair> choose_pairs(const CaptureSet& set,
                                    std::span<const LineIntersection> intersections,
                                    std::span<const std::size_t> keyframes);

}  // namespace raywalk::calibrate
