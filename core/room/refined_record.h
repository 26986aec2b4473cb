// What a refined room was developed from, in ROOM/refined.json. Written by `raywalk-build-lf
// refine`.
//
//   {"format": "raywalk-refined", "format_version": 1,
//    "source": "../hall.lf",          the captured room, relative to this one
//    "source_fingerprint": "...",     room_fingerprint() of it
//    "source_stations": 244,
//    "hold_out": 0,                   every how many-th of them was left out; 0: none
//    "sharpening": [0.9, 1.2]}        the least and the largest that a station needed
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "core/room/room.h"

namespace raywalk {

struct RefinedRecord {
  std::filesystem::path source{};
  std::string source_fingerprint{};
  int source_stations = 0;
  int hold_out = 0;
  std::array<double, 2> sharpening{0.0, 0.0};
};

// Where the room that is developed from one is by default: "hall-refined.lf" beside "hall.lf".
std::filesystem::path refined_room_path(const std::filesystem::path& room);

// The room there, if it was developed from all photographs and the distances that `room` has now.
// Warns of one that was developed from earlier ones.
std::optional<Room> current_refined_room(const Room& room);

// Throws Error if it cannot be written.
void write_refined_record(const std::filesystem::path& room, const RefinedRecord& record);

// None if the room is not a refined one. Throws Error naming the file if it is damaged or of a
// newer version.
std::optional<RefinedRecord> read_refined_record(const std::filesystem::path& room);

// For people: "developed from 244 photographs of ../hall.lf", and whether that has changed since
// or cannot be opened; empty if the room is not a refined one. Throws as read_refined_record does.
std::string refined_text(const std::filesystem::path& room);

}  // namespace raywalk
