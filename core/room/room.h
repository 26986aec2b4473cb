// A room on disk: `manifest.json`, one volume per line in `lines/<id>.h5`, distance maps in
// `distances/given/<id>.h5` and `distances/estimated/<id>.h5`, the stations' gains in `gains.h5`.
// Written by raywalk-build-lf, read here by every later stage.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/distance_volume.h"
#include "core/room/gain_fields.h"
#include "core/room/line_volume.h"

namespace raywalk {

// Manifests of other versions are refused.
inline constexpr int kRoomFormatVersion = 3;

// The distances that a room has: packed with it, or estimated from its panoramas.
enum class DistanceKind { kNone, kGiven, kEstimated };
inline constexpr std::array kDistanceKinds{DistanceKind::kNone, DistanceKind::kGiven,
                                           DistanceKind::kEstimated};
std::string name_of(DistanceKind kind);  // "none", "given" or "estimated"

// What a room was developed from by `raywalk-build-lf refine`.
struct RefinedRecord {
  std::filesystem::path source{};    // the captured room, relative to this one
  std::string source_fingerprint{};  // room_fingerprint() of it
  int source_stations = 0;
  int hold_out = 0;                            // every how many-th of them was left out; 0: none
  std::array<double, 2> sharpening{0.0, 0.0};  // the least and the largest that a station needed
};

// The content of manifest.json.
struct RoomManifest {
  PanoramaSize panorama;  // of every captured frame
  Grid grid;
  // Checksum of each line's rays: SHA-256 over the text of its stations' checksums (dataset
  // `sha256` of lines/<id>.h5), to detect a volume of another room. Empty: unknown.
  std::vector<std::string> rays_sha256;
  // Those that views use, of the folder of this name.
  DistanceKind distances = DistanceKind::kNone;
  // Whether views apply gains.h5.
  bool gains = false;
  std::optional<RefinedRecord> refined{};  // none: a captured room
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
std::filesystem::path distances_directory(const std::filesystem::path& room, DistanceKind kind);
std::filesystem::path distance_volume_path(const std::filesystem::path& room,
                                           const std::string& line_id,
                                           DistanceKind kind = DistanceKind::kGiven);

// Selected stations of each line (see core/room/kept_stations.h): increasing indices, at least two.
using KeptStations = std::vector<std::vector<int>>;

// An opened room: volumes are memory-mapped, so data is read on first access.
class Room {
 public:
  // Opens a complete room. Throws Error when the directory, the manifest or a volume is missing,
  // truncated or does not match the manifest. `raywalk-build-lf verify` reads volumes whole.
  static Room open(const std::filesystem::path& directory);

  // The same without its gains, whatever their state.
  static Room open_without_gains(const std::filesystem::path& directory);

  // The same without its distances and gains, whatever their state.
  static Room open_rays(const std::filesystem::path& directory);

  // The room with a subset of its stations, as if the others, their distance maps and gains had not
  // been captured. Mappings are shared. Throws UsageError if a line would have fewer than two
  // stations, or `kept` does not match this room.
  Room subset(const KeptStations& kept) const;

  // The room with its distance maps replaced by those in a folder with a volume for each line.
  // Throws Error as open() does.
  Room with_distances(const std::filesystem::path& directory) const;

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
  // Whether any station has a mask (LineVolume::valid_rows).
  bool masked() const;

 private:
  void open_distances();
  void open_gains();

  std::filesystem::path directory_;
  RoomManifest manifest_;
  std::vector<LineVolume> volumes_;
  std::vector<DistanceVolume> distances_;
  GainFields gains_;
};

// What detects that a room has changed since earlier results were made from it. A hexadecimal
// SHA-256 of the distances that its views use: over the positions and checksums of the maps.
std::string distances_sha256(const Room& room);
// One that changes when the rays, the distances or the gains of a room do.
std::string room_fingerprint(const Room& room);

}  // namespace raywalk
