// Replaces and removes the gains of a room. Every change leaves a room that is valid at each
// moment: the manifest first records the old and the new file, then the file is renamed.
#pragma once

#include <filesystem>

#include "core/room/gain_fields.h"

namespace raywalk::build_lf {

// Makes these the gains of the room: ROOM/gains.h5, recorded in the manifest; no file if all are 1.
// Removes measurements made with others. Throws Error if it cannot be written or another process is
// changing the room.
void replace_gains(const std::filesystem::path& room, const GainFields& fields);

// Removes the gains; whether there were any.
bool remove_gains(const std::filesystem::path& room);

}  // namespace raywalk::build_lf
