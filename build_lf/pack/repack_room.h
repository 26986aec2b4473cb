// Stores the panoramas of a room in another form: `raywalk-build-lf repack`.
#pragma once

#include <filesystem>

#include "core/room/ray_form.h"

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

}  // namespace raywalk::build_lf
