// The working directory `<room>/distances.partial` of a depth run, which replaces
// `<room>/distances/estimated` when complete. A stopped run leaves its finished maps there, to be
// resumed. Processes that do a part of a step each share it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/pack/work_part.h"
#include "core/files/file_lock.h"

namespace raywalk::build_lf {

// The stage of finished maps.
inline constexpr const char* kFinalStage = "final";

enum class MapsUse {
  kAlone,   // starts over where the maps are of other inputs
  kShared,  // one of several processes, after one that had the directory alone
};

class PartialMaps {
 public:
  // Creates or reuses the directory and locks it; maps with another fingerprint (room, settings)
  // are removed by kAlone. `volumes`: the directory of the volumes in it. Throws Error if another
  // run holds the lock, the room cannot be written and, for kShared, if there are no maps or ones
  // with another fingerprint.
  PartialMaps(const std::filesystem::path& room, const std::string& fingerprint,
              MapsUse use = MapsUse::kAlone, const std::string& volumes = "volumes");
  // Removes the directory if this run began it and failed before its first map.
  ~PartialMaps();
  PartialMaps(const PartialMaps&) = delete;
  PartialMaps& operator=(const PartialMaps&) = delete;

  // Stores a map of a stage (kFinalStage or an intermediate one), atomically. Throws Error if it
  // cannot be written.
  void store(const std::string& stage, const InverseDistanceMap& map);
  // Whether a map is stored, damaged or not.
  bool has(const std::string& stage, StationIndex station) const;
  // A stored map; none if it is missing or damaged.
  std::optional<InverseDistanceMap> load(const std::string& stage, StationIndex station) const;
  // The same for a map known to be stored. Throws Error if it is missing or damaged; a damaged one
  // is removed, to be made again.
  InverseDistanceMap stored(const std::string& stage, StationIndex station) const;

  // Other bytes of a run, under a name, in the same way.
  void store_bytes(const std::string& name, std::string bytes);
  std::optional<std::string> load_bytes(const std::string& name) const;

  // The directory itself: what is written there under names of temporary_beside() is in nobody's
  // way.
  const std::filesystem::path& directory() const { return directory_; }
  // The existing directory to write the volumes to.
  const std::filesystem::path& volumes() const { return volumes_; }
  // Moves the volumes to `<room>/distances/estimated`, atomically if the file system can exchange
  // directories, and removes everything else. Throws Error on failure.
  void complete();

 private:
  void prepare(const std::string& fingerprint);
  bool is_of(const std::string& fingerprint) const;

  std::filesystem::path room_;
  std::filesystem::path directory_;
  std::filesystem::path volumes_;
  FileLock lock_;
  bool removable_ = false;  // nothing is in the directory that took time
};

// Makes those maps of a share of the plan that are not stored, one after another: `make` gives the
// map of plan.maps[i]. `doing` names the work for the terminal. Throws Interrupted, and as
// PartialMaps.
void make_maps(const DepthPlan& plan, IndexRange share, const char* stage, const char* doing,
               PartialMaps* partial, const std::function<InverseDistanceMap(int map)>& make);

// Writes the finished maps of those of the lines that are not written yet to partial.volumes(), and
// what views leave out of each line's stations, which `contradictions_of` finds. Throws Error if a
// map is damaged or cannot be written, and Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, IndexRange lines,
                   const LineSearch& contradictions_of);

}  // namespace raywalk::build_lf
