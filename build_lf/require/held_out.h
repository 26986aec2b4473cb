// Hold-out measurement: how well stations are re-created from the stations kept around them
// (core/judge/held_out).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/block.h"
#include "core/judge/held_out/recreated_station.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// For strides 2, 3, 4, 6, 8, ...: leaves out the stations between every stride-th one of a line, a
// gap at a time, and re-creates the middle one, which is the hardest; a dozen per stride, spread
// over the room. Distances are gathered from all maps of the room but the station's own. Empty if
// no line has three stations. `tolerance_px` is for psnr_of_tolerance_db. Throws Interrupted.
std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px);

// The same in parts: the number of stations to re-create, the scores of some of them, and the
// result from all scores in order.
std::size_t recreated_stations(const Grid& grid);
std::vector<RecreationScore> score_recreations(const Room& room, double tolerance_px,
                                               IndexRange share);
std::vector<HeldOutFacts> facts_of_strides(const Grid& grid,
                                           std::span<const RecreationScore> scores);

// The largest step, metres, such that for it and all smaller ones the PSNR of stations re-created
// with distances is at least that of the tolerance. 0 if there is none.
double measured_up_to_m(std::span<const HeldOutFacts> strides);

}  // namespace raywalk::build_lf
