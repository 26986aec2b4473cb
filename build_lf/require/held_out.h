// Hold-out measurement: re-creates stations from the stations kept around them.
#pragma once

#include <span>
#include <vector>

#include "build_lf/require/recreated_view.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A station of a line and its kept neighbours, as indices.
struct HeldOutStation {
  int line = 0;
  int station = 0;
  int left = 0;
  int right = 0;
};

// Re-creates each station of `room`, using the nearest maps of `distances` (the room itself or
// another one of the same place). The station's own map is not used; without any other map
// everything is taken to be infinitely far. `tolerance_px` is for psnr_of_tolerance_db. Runs in
// parallel; memory does not grow with the number of stations. Throws Interrupted.
std::vector<RecreationScore> recreate_stations(const Room& room, const Room& distances,
                                               std::span<const HeldOutStation> stations,
                                               double tolerance_px);

// At most `count` of the stations, spread evenly.
std::vector<HeldOutStation> pick_evenly(std::span<const HeldOutStation> stations, int count);

// For strides 2, 3, 4, 6, 8, ...: keeps every stride-th station of every line that is long enough
// and re-creates the middle one of each gap, which is the hardest; a dozen per stride, spread over
// the room. Empty if no line has three stations.
std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px);

// The largest step, metres, such that for it and all smaller ones the PSNR of stations re-created
// with distances is at least that of the tolerance. 0 if there is none.
double measured_up_to_m(std::span<const HeldOutFacts> strides);

}  // namespace raywalk::build_lf
