// The directory `<room>/distances.partial` in which distance maps are made, until they are complete
// and take the place of `<room>/distances`. A run that was stopped leaves its finished maps there
// for the next one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/files/file_lock.h"

namespace raywalk::build_lf {

// The stage of maps that are finished.
inline constexpr const char* kFinalStage = "final";

class PartialMaps {
 public:
  // Makes or takes over the directory and locks it; maps of another fingerprint (room, settings)
  // are removed. Throws Error: another run is at work, or the room cannot be written.
  PartialMaps(const std::filesystem::path& room, const std::string& fingerprint);
  PartialMaps(const PartialMaps&) = delete;
  PartialMaps& operator=(const PartialMaps&) = delete;

  // Keeps a map of a stage (kFinalStage, or a step on the way). It appears only when complete.
  void store(const std::string& stage, const InverseDistanceMap& map);
  // The map as it was stored; none if there is none or it is damaged.
  std::optional<InverseDistanceMap> load(const std::string& stage, StationIndex station,
                                         const Eigen::Vector3d& position_m,
                                         PanoramaSize size) const;

  // The same for a map that has been stored. Throws Error if it is damaged or not there.
  InverseDistanceMap load_stored(const std::string& stage, StationIndex station,
                                 const Eigen::Vector3d& position_m, PanoramaSize size) const;

  // Where the volumes are to be written: a directory that exists.
  const std::filesystem::path& volumes() const { return volumes_; }
  // Moves the volumes to `<room>/distances`, in one step where the file system can exchange
  // directories, and removes everything else. What was there is removed, or, where `keep_as` is not
  // empty, kept as `<room>/<keep_as>` in place of what is there. Throws Error.
  void complete(const std::string& keep_as);

 private:
  std::filesystem::path file_of(const std::string& stage, StationIndex station) const;

  std::filesystem::path room_;
  std::filesystem::path directory_;
  std::filesystem::path volumes_;
  FileLock lock_;
};

}  // namespace raywalk::build_lf
