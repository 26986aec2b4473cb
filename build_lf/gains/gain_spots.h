// Tells people, cars and lamps from exposure by their size.
#pragma once

#include <span>
#include <vector>

namespace raywalk::build_lf {

// The log gains of one station's patches in one channel (patch_ratios.h) without spots: a patch
// that differs by more than 10 % from the median of the patches around it, 5 x 5 at the horizon
// and nearly as wide elsewhere, takes that median. What one station shows and the others do not is
// no larger than that, unless it is very near; the picture of a lens and the shadow of a cloud are,
// and a median keeps their edges.
std::vector<double> without_spots(std::span<const double> patches);

}  // namespace raywalk::build_lf
