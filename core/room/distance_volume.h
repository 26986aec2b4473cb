// The distance maps of one line, mapped from `distances/<id>.h5`.
//
// Datasets: `station` int32 [maps] (station index of each map, increasing), `distance_m` float32
// [maps][theta][phi] (metres along the ray to the first surface; +inf: none, e.g. open sky),
// `confidence` uint8 [maps][theta][phi] (0 = unknown, 255 = certain). Both are stored contiguously
// in the layout of the rays; width and height may be smaller than the panorama's. Optional:
// `left_out` int32 [runs][station, theta, first row, one past the last row], pixels of the line's
// stations, with or without a map, in the maps' size (left_out.h). In rooms
// with compressed panoramas the maps are compressed too (deflated_maps.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/deflated_maps.h"
#include "core/room/left_out.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {

// The root attribute `format` of distances/<id>.h5.
inline constexpr const char* kDistanceVolumeFormat = "raywalk-distances";
// The root attribute `origin` of distances packed with the room; estimated ones name their method.
// A missing attribute means packed. The root attribute `line` is the id of the line.
inline constexpr const char* kGivenOrigin = "given";

// Views ignore distances of lower confidence: more of them are wrong than right (measured by
// raywalk-build-lf depth --truth).
inline constexpr std::uint8_t kMinConfidence = 64;

class DistanceVolume {
 public:
  DistanceVolume() = default;  // no maps

  // Maps the file read-only. Throws Error naming the file when it is missing, not HDF5, truncated,
  // of a newer format version, has datasets of the wrong shape, or names a station the line does
  // not have.
  static DistanceVolume open(const std::filesystem::path& file, int stations_of_line);

  // The maps of a subset of the line's stations (increasing indices), renumbered from 0; the
  // mapping is shared.
  DistanceVolume subset(std::span<const int> stations_of_line) const;

  // The same line with other maps, held in memory: of the given stations (increasing), [map][theta]
  // [phi] as in the datasets. header_sha256() and bytes() remain those of the file.
  DistanceVolume with_maps(std::vector<int> stations, PanoramaSize size,
                           std::vector<float> distance_m,
                           std::vector<std::uint8_t> confidence) const;

  int maps() const { return static_cast<int>(stations_.size()); }
  // Station index of each map, increasing.
  std::span<const int> stations() const { return stations_; }
  PanoramaSize size() const { return size_; }
  // Where the maps come from: kGivenOrigin, or how they were estimated ("estimated by sweep").
  const std::string& origin() const { return origin_; }
  // Whether the maps were packed with the room rather than estimated.
  bool given() const { return origin_ == kGivenOrigin; }
  // The id of the line that the file says it belongs to; empty if it does not say.
  const std::string& line() const { return line_; }
  // Size of the file.
  std::uint64_t bytes() const { return bytes_; }
  // Identifies the file's content without reading it: SHA-256 over line, origin, size, stations and
  // the stored checksums of the maps, and the pixels left out if there are any.
  const std::string& header_sha256() const { return header_sha256_; }
  // Pixels of the line's stations that views leave out.
  const LeftOutPixels& left_out() const { return left_out_; }
  // One column of a map, height values top to bottom; `map` in [0, maps), `theta` in [0, width).
  // Of a compressed volume they decode the map, and throw Error where it is damaged.
  std::span<const float> distance_column(int map, int theta) const {
    load(map);
    return {distance_m_.get() + offset(map, theta), rows()};
  }
  std::span<const std::uint8_t> confidence_column(int map, int theta) const {
    load(map);
    return {confidence_.get() + offset(map, theta), rows()};
  }

  // Whether the maps are compressed.
  bool compressed() const { return deflated_ != nullptr; }

 private:
  void load(int map) const {
    if (deflated_) deflated_->load(static_cast<size_t>(stored_[static_cast<size_t>(map)]));
  }
  size_t rows() const { return static_cast<size_t>(size_.height); }
  size_t offset(int map, int theta) const {
    return (static_cast<size_t>(stored_[static_cast<size_t>(map)]) *
                static_cast<size_t>(size_.width) +
            static_cast<size_t>(theta)) *
           rows();
  }

  std::vector<int> stations_;
  std::vector<int> stored_;  // of each map, its index in the file or memory
  PanoramaSize size_;
  std::string origin_;
  std::string line_;
  std::uint64_t bytes_ = 0;
  std::string header_sha256_;
  LeftOutPixels left_out_;
  std::shared_ptr<DeflatedMaps> deflated_;  // null where the maps are not compressed
  // Shared with the dataset or the memory that holds them.
  std::shared_ptr<const float> distance_m_;
  std::shared_ptr<const std::uint8_t> confidence_;
};

}  // namespace raywalk
