// The HTML report of `raywalk-build-lf require`.
#pragma once

#include <string>

#include "build_lf/require/thin_room.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A self-contained HTML page with plots of all measurements. `needed` are the stations needed with
// distances.
std::string requirements_page(const Room& room, const RoomRequirements& requirements,
                              const KeptStations& needed);

}  // namespace raywalk::build_lf
