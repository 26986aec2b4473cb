// Volumes of a room that is made of another one: `repack`, `require --thin`.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/base/progress.h"
#include "core/room/ray_form.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The stations and the maps of a room.
std::int64_t images_of(const Room& room);

// Writes the rays of a line of `part`, which is `room` or has some of its stations, to the room
// `out` in `form`; a volume that is there is kept. JPEG is made from what is stored, so from JPEG
// with a further loss, unless all of a line stays as it is: that is copied. Advances `progress` by
// the stations. Throws Error if a file cannot be read or written; Interrupted.
void write_derived_rays(const Room& room, const Room& part, int line, const RayForm& form,
                        const std::filesystem::path& out, Progress* progress);

// Writes the distance maps of a line in the same way, those that are wider than `most_width`
// reduced to it. Advances `progress` by the maps.
void write_derived_maps(const DistanceVolume& maps, const Line& line, DistanceKind kind,
                        int most_width, bool compressed, const std::filesystem::path& out,
                        Progress* progress);

}  // namespace raywalk::build_lf
