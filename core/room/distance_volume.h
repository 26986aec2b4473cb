// The distance maps of one line, mapped from `distances/given/<id>.h5` or
// `distances/estimated/<id>.h5`.
//
// Datasets: `station` int32 [maps] (station index of each map, increasing; may be empty),
// `distance_m` float32 [maps][theta][phi] (metres along the ray to the first surface; +inf: none,
// e.g. open sky), `confidence` uint8 [maps][theta][phi] (0 = unknown, 255 = certain). Both are
// stored contiguously in the layout of the rays; width and height may be smaller than the
// panorama's. In rooms with compressed panoramas they are compressed by HDF5's own filters, shuffle
// and deflate, a chunk to a map. Optional: `left_out` int32 [runs][station, theta, first row, one
// past the last row], pixels of the line's stations, with or without a map, in the maps' size
// (LeftOutPixels); `sha256`, a checksum of each map. Root attributes, which files of other programs
// may lack: `line` (its id), `origin`, `stations_sha256` (sha256_of the line) and `header_sha256`
// (sha256_of the header).
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"
#include "core/room/line_volume.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {

// The root attribute `format` of a distance volume.
inline constexpr const char* kDistanceVolumeFormat = "raywalk-distances";
// The root attribute `origin` of distances packed with the room; estimated ones name their method.
// A missing attribute means packed.
inline constexpr const char* kGivenOrigin = "given";

// Views ignore distances of lower confidence: more of them are wrong than right (measured by
// raywalk-build-lf depth --truth).
inline constexpr std::uint8_t kMinConfidence = 64;

// What tells a line of one room from that of another: over its id and the positions of its
// stations.
std::string sha256_of(const Line& line);

// What identifies a volume's content without reading its maps.
struct DistanceHeader {
  std::string line{};
  std::string origin{};
  PanoramaSize size{};
  std::span<const std::int32_t> stations{};
  std::span<const std::string> map_sha256{};  // checksum of each map
  std::span<const std::int32_t> left_out{};
};
std::string sha256_of(const DistanceHeader& header);

// Rows of a column of a station.
struct LeftOutRun : RowRun {
  int station = 0;
  int theta = 0;
};

// Pixels of a line's stations that views leave out where another station sees the place: people and
// cars that moved while the room was captured.
class LeftOutPixels {
 public:
  LeftOutPixels() = default;  // none

  // From runs of pixels of panoramas of `size`: [run][4] = station, theta, first row, one past the
  // last row, in any order. Throws Error naming `source` for a run outside the line's `stations` or
  // the panorama.
  LeftOutPixels(std::span<const std::int32_t> runs, PanoramaSize size, int stations,
                const std::string& source);

  // The pixels of a subset of the stations (increasing indices), renumbered from 0.
  LeftOutPixels subset(std::span<const int> stations) const;

  // All runs, as they are stored for panoramas of `size`; pixels that are partly left out are.
  std::vector<std::int32_t> stored_runs(PanoramaSize size) const;

  PanoramaSize size() const { return size_; }
  // Whether any pixel of the station is left out.
  bool any(int station) const { return !runs_of(station).empty(); }
  // The runs of rows left out in column theta of a station, from the top.
  std::span<const LeftOutRun> rows(int station, int theta) const;

 private:
  std::span<const LeftOutRun> runs_of(int station) const;

  PanoramaSize size_;
  std::vector<LeftOutRun> runs_;  // by station, theta and row
};

class DistanceVolume {
 public:
  DistanceVolume() = default;  // no maps

  // Maps the file read-only. Throws Error naming the file when it is missing, not HDF5, truncated,
  // of another format version or another line, has datasets of the wrong shape, or names a station
  // the line does not have.
  static DistanceVolume open(const std::filesystem::path& file, const Line& line);

  // The maps of a subset of the line's stations (increasing indices), renumbered from 0; the
  // mapping is shared.
  DistanceVolume subset(std::span<const int> stations_of_line) const;

  int maps() const { return static_cast<int>(stations_.size()); }
  // Station index of each map, increasing.
  std::span<const int> stations() const { return stations_; }
  // The map of a station of the line, if it has one.
  std::optional<int> map_of(int station) const {
    const auto found = std::ranges::lower_bound(stations_, station);
    if (found == stations_.end() || *found != station) return std::nullopt;
    return static_cast<int>(found - stations_.begin());
  }
  PanoramaSize size() const { return size_; }
  // Where the maps come from: kGivenOrigin, or how they were estimated ("estimated by sweep").
  const std::string& origin() const { return origin_; }
  // Whether the maps were packed with the room rather than estimated.
  bool given() const { return origin_ == kGivenOrigin; }
  // sha256_of the header; of files of other programs, which have no checksums, with the file's size
  // and modification time.
  const std::string& header_sha256() const { return header_sha256_; }
  // Pixels of the line's stations that views leave out.
  const LeftOutPixels& left_out() const { return left_out_; }
  // One column of a map, height values top to bottom; `map` in [0, maps), `theta` in [0, width).
  // Of a compressed volume they decode the map, and throw Error where it is damaged.
  std::span<const float> distance_column(int map, int theta) const {
    const float* const first = deflated_ ? decoded(map).distance_m.data() : distance_m_.get();
    return {first + offset(map, theta), rows()};
  }
  std::span<const std::uint8_t> confidence_column(int map, int theta) const {
    const std::uint8_t* const first =
        deflated_ ? decoded(map).confidence.data() : confidence_.get();
    return {first + offset(map, theta), rows()};
  }

  // Whether the maps are compressed.
  bool compressed() const { return deflated_ != nullptr; }

 private:
  struct Map {
    std::vector<float> distance_m;
    std::vector<std::uint8_t> confidence;
  };
  class DeflatedMaps;

  // A map of a compressed volume.
  const Map& decoded(int map) const;
  std::size_t rows() const { return static_cast<std::size_t>(size_.height); }
  // From the first value of all maps; of a compressed volume, of the map.
  std::size_t offset(int map, int theta) const {
    const int before = deflated_ ? 0 : stored_[static_cast<std::size_t>(map)];
    return (static_cast<std::size_t>(before) * static_cast<std::size_t>(size_.width) +
            static_cast<std::size_t>(theta)) *
           rows();
  }

  std::vector<int> stations_;
  std::vector<int> stored_;  // of each map, its index in the file or memory
  PanoramaSize size_;
  std::string origin_;
  std::string header_sha256_;
  LeftOutPixels left_out_;
  std::shared_ptr<DeflatedMaps> deflated_;  // null where the maps are not compressed
  // All maps otherwise, shared with the dataset or the memory that holds them.
  std::shared_ptr<const float> distance_m_;
  std::shared_ptr<const std::uint8_t> confidence_;
};

// The volumes of a folder, one for each line of the grid. Throws Error as DistanceVolume::open
// does; where a line has no map, its file says so.
std::vector<DistanceVolume> open_distance_volumes(const std::filesystem::path& folder,
                                                  const Grid& grid);

// Where the maps come from, for reports: the origin of the volumes, different ones joined by
// " and ", or "none".
std::string origin_of(std::span<const DistanceVolume> volumes);

}  // namespace raywalk
