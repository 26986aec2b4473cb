// Hold-out measurement: how well stations are re-created from the stations kept around them
// (core/evaluate/recreated_station.h).
#pragma once

#include <span>
#include <vector>

#include "build_lf/require/facts.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// For strides 2, 3, 4, 6, 8, ...: leaves out the stations between every stride-th one of a line, a
// gap at a time, and re-creates the middle one, which is the hardest; a dozen per stride, spread
// over the room. Distances are gathered from all maps of the room but the station's own. Empty if
// no line has three stations. `tolerance_px` is for psnr_of_tolerance_db. Throws Interrupted.
std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px);

// The largest step, metres, such that for it and all smaller ones the PSNR of stations re-created
// with distances is at least that of the tolerance. 0 if there is none.
double measured_up_to_m(std::span<const HeldOutFacts> strides);

}  // namespace raywalk::build_lf
