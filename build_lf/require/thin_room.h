// Writes the part of a room that its scene requires: `raywalk-build-lf require --thin`.
#pragma once

#include <filesystem>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Writes the room `out` that holds `kept` alone: the same lines, cells, rays, and the distances of
// those stations, sampled at `distance_width` where their maps are wider. It appears only when
// complete; until then a run that was stopped is resumed by the same call, from the last volume it
// finished. Panoramas are copied one per thread at a time. Throws Error where `out` exists or
// cannot be written, Interrupted.
void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const std::filesystem::path& out);

// Compares it with the room it was made from: stations that were dropped are made again from what
// it holds, at most some dozens spread over the room. 100 dB where none was dropped. `kept` must
// hold a station with a distance map.
ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept,
                           const std::filesystem::path& out, double tolerance_px);

}  // namespace raywalk::build_lf
