// Rooms that are made of another one: `raywalk-build-lf repack`, `require --thin`.
#pragma once

#include <filesystem>

#include "core/room/ray_form.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct RepackOptions {
  std::filesystem::path room;
  std::filesystem::path out;  // the room directory to create
  RayForm form{};
  bool replace = false;  // a room at `out` is replaced
};

// "hall-jpeg95.lf" beside "hall.lf".
std::filesystem::path default_repacked_name(const std::filesystem::path& room, const RayForm& form);

// Creates a room like `options.room`, with its distances, gains and what else it holds but for what
// was measured of its views, whose times and quality change with the form. A line that has the form
// already is copied; JPEG is made from what is stored, so from JPEG with a further loss. The room
// appears only when complete; a stopped run is resumed by the same command. Throws Error as
// Room::open and pack_room do.
void repack_room(const RepackOptions& options);

// Creates the room `out` with the stations `kept`: same lines and cells, their rays and gains, and
// the distance maps in use, reduced to `distance_width` if wider. Rays are stored in the same form:
// of JPEG, those of a line that loses stations lose once more. `out` appears only when complete,
// with `replace` in place of a room; the same call resumes a stopped run. Throws as repack_room().
void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const std::filesystem::path& out, bool replace = false);

}  // namespace raywalk::build_lf
