// Writes a room with only the data its scene requires: `raywalk-build-lf require --thin`.
#pragma once

#include <filesystem>

#include "build_lf/require/facts.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Writes the room `out` with the stations `kept`: same lines and cells, their rays and gains, and
// their distance maps, reduced to `distance_width` if wider. Rays are stored in the same form: of
// JPEG, those of a line that loses stations lose once more. `out` appears only when complete; the
// same call resumes a stopped run after its last finished volume. Each thread holds one panorama at
// a time. With `replace`, a room that is `out` is replaced then. Throws Error as PartialRoom does,
// and Interrupted.
void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const std::filesystem::path& out, bool replace = false);

// Compares the thinned room with its source: re-creates dropped stations from it, at most 48 spread
// over the room. 100 dB if none was dropped. `kept` must include a station with a distance map.
ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept,
                           const std::filesystem::path& out);

}  // namespace raywalk::build_lf
