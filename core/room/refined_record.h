// Rooms that `raywalk-build-lf refine` developed from captured ones, and what they were developed
// from (RefinedRecord in room.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/room/room.h"

namespace raywalk {

// Where the room that is developed from one is by default: "hall-refined.lf" beside "hall.lf".
std::filesystem::path refined_room_path(const std::filesystem::path& room);

// The room there, if it was developed from all photographs and the distances that `room` has now.
// Warns of one that was developed from earlier ones.
std::optional<Room> current_refined_room(const Room& room);

// For people: "developed from 244 photographs of ../hall.lf", and whether that has changed since
// or cannot be opened; empty if the room is not a refined one.
std::string refined_text(const Room& room);

}  // namespace raywalk
