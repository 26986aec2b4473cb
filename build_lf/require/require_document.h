// What `raywalk-build-lf require` writes to require.json and shows in its report.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The requirements_document() of a room, with what the report shows besides.
nlohmann::ordered_json require_document(const Room& room, const RoomRequirements& requirements);

}  // namespace raywalk::build_lf
