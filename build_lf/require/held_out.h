// Stations left out and made again from those kept.
#pragma once

#include <span>
#include <vector>

#include "build_lf/require/recreated_view.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A station of a line and the stations kept on either side.
struct HeldOutStation {
  int line = 0;
  int station = 0;
  int left = 0;
  int right = 0;
};

// Makes each station of `room` again, with the nearest maps of `distances`: the room itself, or
// another of the same place. A map captured where the station stands is not used; where no other is
// there, everything counts as infinitely far. `tolerance_px` is for psnr_of_tolerance_db. In
// parallel; memory does not grow with the number of stations. Throws Interrupted.
std::vector<RecreationScore> recreate_stations(const Room& room, const Room& distances,
                                               std::span<const HeldOutStation> stations,
                                               double tolerance_px);

// At most `count` of them, spread evenly.
std::vector<HeldOutStation> spread_over(std::span<const HeldOutStation> stations, int count);

// Keeps every second, third, fourth, sixth, eighth, ... station of every line that is long enough
// and makes the middle one of each gap again, the hardest; of a stride a dozen spread over the
// room. Empty where no line has three stations.
std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px);

// The largest step at which, as at all smaller ones, stations made again with distances are no
// farther from the captured ones than the tolerance is. 0 where none is.
double measured_up_to_m(std::span<const HeldOutFacts> strides);

}  // namespace raywalk::build_lf
