// The distances of a room, given with it in ROOM/distances/given and estimated from its panoramas
// in ROOM/distances/estimated, and which of them views use: `raywalk-build-lf distances`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/room/room.h"

namespace raywalk::build_lf {

struct FoundDistances {
  DistanceKind kind = DistanceKind::kGiven;
  std::filesystem::path folder{};
  bool in_use = false;
  std::vector<DistanceVolume> volumes{};  // of each line; empty where they cannot be used
  std::string origin{};                   // of their maps
  std::string fault{};                    // why they cannot be used; empty: they can
};

// Those that are there, or should be. Reads headers of files.
std::vector<FoundDistances> find_distances(const std::filesystem::path& room,
                                           const RoomManifest& manifest);

// A list of them for a terminal.
std::string distances_text(const std::filesystem::path& room);

// "given" or "estimated". Throws UsageError naming both for another name.
DistanceKind distance_kind_from_name(const std::string& name);

// Lets views use the distances of a kind. Returns a sentence for the terminal. Throws Error if
// there are none, they are damaged, or another process is changing them.
std::string use_distances(const std::filesystem::path& room, DistanceKind kind);

}  // namespace raywalk::build_lf
