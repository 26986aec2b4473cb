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

// Writes the volumes of a line of `part`, which is `room` or has some of its stations, to the room
// `out`: the rays in `form`, maps that are wider reduced to `distance_width`. A volume that is
// there is kept. JPEG is made from what is stored, so from JPEG with a further loss, unless all of
// a line stays as it is: that is copied. Advances `progress` by images_of() of the line. Throws
// Error if a file cannot be read or written; Interrupted.
void write_derived_line(const Room& room, const Room& part, int line, const RayForm& form,
                        int distance_width, const std::filesystem::path& out, Progress* progress);

}  // namespace raywalk::build_lf
