// A room on disk: `manifest.json`, one volume per line in `lines/<id>.h5`, the distance maps in use
// in `distances/<id>.h5`, the stations' gains in `gains.h5`. Written by raywalk-build-lf, read here
// by every later stage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/distance_record.h"
#include "core/room/distance_volume.h"
#include "core/room/gain_fields.h"
#include "core/room/line_volume.h"

namespace raywalk {

// The newest manifest this program reads.
inline constexpr int kRoomFormatVersion = 2;
// Format 2 records the room's distance volumes; format 1 does not.
inline constexpr int kUnrecordedDistancesVersion = 1;

// The content of manifest.json.
struct RoomManifest {
  PanoramaSize panorama;  // of every captured frame
  Grid grid;
  // Checksum of each line's rays: SHA-256 over the text of its stations' checksums (dataset
  // `sha256` of lines/<id>.h5), to detect a volume of another room. Empty: unknown.
  std::vector<std::string> rays_sha256;
  // The sets of distance volumes that belong to the room. `distances` holds one of them, whole;
  // which one is read from its files, so that replacing the directory switches at once. None: the
  // manifest says nothing about distances (format 1), so that they cannot be compared.
  std::optional<std::vector<DistanceSet>> distances{};
  // The files that gains.h5 may be, so that replacing it switches at once. Empty: the room has no
  // gains, and what is there is not used.
  std::vector<GainsRecord> gains{};
};

// Text of manifest.json and back. `source` names the text in errors. Parsing throws Error on a
// newer format version, a missing or ill-typed key, a value out of range, or a line or cell that
// contradicts itself.
std::string manifest_to_json(const RoomManifest& manifest);
RoomManifest manifest_from_json(const std::string& text, const std::string& source);

// The manifest of a room. Throws Error when the directory or the manifest is missing, and as
// manifest_from_json.
RoomManifest read_manifest(const std::filesystem::path& room);

// Paths of a room's files.
std::filesystem::path manifest_path(const std::filesystem::path& room);
std::filesystem::path line_volume_path(const std::filesystem::path& room,
                                       const std::string& line_id);
std::filesystem::path distances_directory(const std::filesystem::path& room);
std::filesystem::path distance_volume_path(const std::filesystem::path& room,
                                           const std::string& line_id);

// Selected stations of each line (see core/room/kept_stations.h): increasing indices, at least two.
using KeptStations = std::vector<std::vector<int>>;

// An opened room: volumes are memory-mapped, so data is read on first access.
class Room {
 public:
  // Opens a complete room. Throws Error when the directory, the manifest or a volume is missing,
  // truncated or does not match the manifest. Distances are compared by the size and the header of
  // their files; `raywalk-build-lf verify` reads them whole. Where the manifest does not record
  // them, they are used with a warning.
  static Room open(const std::filesystem::path& directory);

  // The same without its gains, whatever their state.
  static Room open_without_gains(const std::filesystem::path& directory);

  // The same without its distances and gains, whatever their state.
  static Room open_rays(const std::filesystem::path& directory);

  // The room with a subset of its stations, as if the others, their distance maps and gains had not
  // been captured. Mappings are shared. Throws UsageError if a line would have fewer than two
  // stations, or `kept` does not match this room.
  Room subset(const KeptStations& kept) const;

  // The room with its distance maps replaced by those in `directory`, which has the layout of the
  // room's `distances`. Throws Error as open() does.
  Room with_distances(const std::filesystem::path& directory) const;
  // The same with other distances of one line.
  Room with_distances(int line, DistanceVolume distances) const;

  const std::filesystem::path& directory() const { return directory_; }
  const RoomManifest& manifest() const { return manifest_; }
  const Grid& grid() const { return manifest_.grid; }
  PanoramaSize panorama() const { return manifest_.panorama; }
  const LineVolume& volume(int line) const { return volumes_[static_cast<size_t>(line)]; }
  // The distance maps of a line; empty if it has none.
  const DistanceVolume& distances(int line) const { return distances_[static_cast<size_t>(line)]; }
  bool has_distances() const;
  // The gains of the stations, which make their exposures agree; empty if all are 1.
  const GainFields& gains() const { return gains_; }
  // Where the distances come from, for reports: "given", "estimated by sweep", ..., or "none".
  std::string distances_origin() const { return origin_of(distances_); }
  // How its panoramas are stored, for reports: "none", "jpeg:95" (name_of a RayForm), "none and
  // lossless" where lines differ; and the bytes of the files that hold them.
  std::string compression() const;
  std::uint64_t ray_file_bytes() const;
  // Whether any station has a mask (LineVolume::valid_rows).
  bool masked() const;

 private:
  // Opens and compares the distances in use. Returns why they cannot be used.
  std::optional<std::string> open_distances();
  // The same for the gains.
  std::optional<std::string> open_gains();

  std::filesystem::path directory_;
  RoomManifest manifest_;
  std::vector<LineVolume> volumes_;
  std::vector<DistanceVolume> distances_;
  GainFields gains_;
};

}  // namespace raywalk
