// What `raywalk-build-lf require` writes to require.json and shows in its report.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "build_lf/require/facts.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The facts of a room, the distances they were measured on, and what the report shows besides: the
// stations, those of them to keep, and surfaces around them.
nlohmann::ordered_json require_document(const Room& room, const SceneFacts& facts,
                                        const KeptStations& kept);

}  // namespace raywalk::build_lf
