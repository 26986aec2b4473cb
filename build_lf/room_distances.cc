#include "build_lf/room_distances.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr std::array kKinds{DistanceKind::kGiven, DistanceKind::kEstimated};

// What a directory of distances holds: a set of the room, or a fault, or neither.
struct Holding {
  std::optional<DistanceSet> set{};
  std::string fault{};
};

Holding holding_of(const fs::path& directory, const RoomManifest& manifest) {
  Holding holding;
  try {
    holding.set = set_of(open_distance_volumes(directory, manifest.grid), manifest.grid);
  } catch (const Error& unusable) {
    return {.fault = unusable.what()};
  }
  if (!holding.set || !manifest.distances) return holding;
  if (const DistanceSet* recorded = recorded_as(*manifest.distances, *holding.set)) {
    return {.set = *recorded};
  }
  return {.fault = *difference_from_record(*manifest.distances, holding.set, directory)};
}

bool is_recorded(const RoomManifest& manifest, DistanceKind kind) {
  return manifest.distances &&
         std::ranges::any_of(*manifest.distances,
                             [&](const DistanceSet& set) { return kind_of(set) == kind; });
}

}  // namespace

DistanceKind distance_kind_from_name(const std::string& name) {
  for (const DistanceKind kind : kKinds) {
    if (name == name_of(kind)) return kind;
  }
  throw UsageError("--use is '" + name + "'; give given or estimated");
}

std::string name_of(DistanceKind kind) {
  return kind == DistanceKind::kGiven ? "given" : "estimated";
}

DistanceKind other_than(DistanceKind kind) {
  return kind == DistanceKind::kGiven ? DistanceKind::kEstimated : DistanceKind::kGiven;
}

DistanceKind kind_of(const DistanceSet& set) {
  return set.given() ? DistanceKind::kGiven : DistanceKind::kEstimated;
}

fs::path kept_directory(const fs::path& room, DistanceKind kind) {
  return room / ("distances-" + name_of(kind));
}

const FoundDistances* RoomDistances::in_use() const {
  if (given && given->in_use) return &*given;
  return estimated && estimated->in_use ? &*estimated : nullptr;
}

RoomDistances find_distances(const fs::path& room, const RoomManifest& manifest) {
  const fs::path in_use = distances_directory(room);
  RoomDistances all;
  std::array<std::string, kKinds.size()> kept_faults;
  // A set is also looked for where the other kind is kept: an interrupted switch leaves it there.
  for (const fs::path& directory :
       {in_use, kept_directory(room, kKinds[0]), kept_directory(room, kKinds[1])}) {
    Holding holding = holding_of(directory, manifest);
    if (!holding.fault.empty()) {
      if (directory == in_use) all.in_use_fault = holding.fault;
      if (directory == kept_directory(room, kKinds[0])) kept_faults[0] = holding.fault;
      if (directory == kept_directory(room, kKinds[1])) kept_faults[1] = holding.fault;
    }
    if (!holding.set) continue;
    auto& found = kind_of(*holding.set) == DistanceKind::kGiven ? all.given : all.estimated;
    if (!found) found = {std::move(*holding.set), directory, directory == in_use};
  }
  const bool any_recorded = manifest.distances && !manifest.distances->empty();
  if (any_recorded && all.in_use() == nullptr && all.in_use_fault.empty()) {
    all.in_use_fault = in_use.string() + ": the recorded distances are missing";
  }
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    if (all.found(kKinds[i])) continue;
    std::string& fault = i == 0 ? all.given_fault : all.estimated_fault;
    if (is_recorded(manifest, kKinds[i])) {
      fault = kept_faults[i].empty() ? kept_directory(room, kKinds[i]).string() +
                                           ": the recorded distances are missing"
                                     : kept_faults[i];
    } else if (!manifest.distances) {
      fault = kept_faults[i];
    }
  }
  return all;
}

}  // namespace raywalk::build_lf
