// Finds the sets of distance maps that belong to a room: given with it, or estimated from its
// panoramas. The set in use is in ROOM/distances, the other one in ROOM/distances-given or
// ROOM/distances-estimated.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/room/room.h"

namespace raywalk::build_lf {

enum class DistanceKind { kGiven, kEstimated };

// "given" or "estimated". Throws UsageError naming both for another name.
DistanceKind distance_kind_from_name(const std::string& name);
std::string name_of(DistanceKind kind);
DistanceKind other_than(DistanceKind kind);
DistanceKind kind_of(const DistanceSet& set);

// Where a set of this kind is kept while it is not in use.
std::filesystem::path kept_directory(const std::filesystem::path& room, DistanceKind kind);

struct FoundDistances {
  DistanceSet set{};  // without checksums of files if the manifest records no distances
  std::filesystem::path directory{};
  bool in_use = false;
};

struct RoomDistances {
  std::optional<FoundDistances> given{};
  std::optional<FoundDistances> estimated{};
  // Why a set that should be there was not found: it is missing or not as recorded. Empty: none
  // should be there, or it was found.
  std::string given_fault{};
  std::string estimated_fault{};
  // Why ROOM/distances cannot be used. Empty: it can, or nothing should be there.
  std::string in_use_fault{};

  const std::optional<FoundDistances>& found(DistanceKind kind) const {
    return kind == DistanceKind::kGiven ? given : estimated;
  }
  const std::string& fault(DistanceKind kind) const {
    return kind == DistanceKind::kGiven ? given_fault : estimated_fault;
  }
  // The set in use; null if there is none.
  const FoundDistances* in_use() const;
};

// Compares headers and sizes of files. If the manifest does not record distances, every readable
// set counts.
RoomDistances find_distances(const std::filesystem::path& room, const RoomManifest& manifest);

}  // namespace raywalk::build_lf
