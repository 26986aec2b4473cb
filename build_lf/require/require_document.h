// What `raywalk-build-lf require` writes to require.json and shows in its report.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The requirements_document() of a room, with what the report shows besides: the k that views use,
// errors over k, the stations, those of them to keep, and surfaces around them.
nlohmann::ordered_json require_document(const Room& room, const RoomRequirements& requirements,
                                        const KeptStations& kept);

}  // namespace raywalk::build_lf
