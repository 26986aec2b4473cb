// Changes which distances of a room are in use or recorded: `raywalk-build-lf distances`, and the
// last step of `depth`. Every change leaves a room that is valid at each moment: the manifest first
// records old and new sets, then the files are moved.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "build_lf/room_distances.h"

namespace raywalk::build_lf {

// A list of the room's distances and which are in use. Throws Error if those in use are damaged,
// missing or not as recorded.
std::string distances_text(const std::filesystem::path& room);

// Makes the set of a kind the one in use and removes measurements made with the other. Returns a
// sentence for the terminal. Distances in use that are not as recorded are kept as the other set.
// Throws Error if there is no such set or another process is changing them.
std::string use_distances(const std::filesystem::path& room, DistanceKind kind);

// Records the distances that are there, in place of what the manifest says. Returns a sentence for
// the terminal. Throws Error as open_distance_volumes does, if sets are kept but none is in use,
// and if another process is changing them.
std::string record_distances(const std::filesystem::path& room);

// Throws Error if estimated distances cannot replace those in use: they are damaged or not as
// recorded, and may be given ones, which must be kept. Warns if others are lost.
void require_distances_replaceable(const std::filesystem::path& room);

// Puts the finished volumes of a directory in use as the room's estimated distances. `move_in`
// renames them to ROOM/distances; the previous ones are kept in the directory of the name it is
// given, or dropped if that is empty. Removes measurements made with the previous distances. Throws
// Error as require_replaceable, if the manifest cannot be written, or if another process is
// changing the room's distances.
void replace_estimated(const std::filesystem::path& room, const std::filesystem::path& volumes,
                       const std::function<void(const std::string& keep_as)>& move_in);

}  // namespace raywalk::build_lf
