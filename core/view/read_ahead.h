// Starts reading from disk what a view will read of the stations, so that a room that was not
// looked at yet is not read one page after the other.
#pragma once

#include "core/view/station_mixing.h"
#include "core/view/viewport.h"

namespace raywalk {

void read_ahead(const MixedView& view, const PanoramaPart& part);

}  // namespace raywalk
