// The distance maps of one line, mapped from `distances/<id>.h5`.
//
// Datasets: `station` int32 [maps] (station index of each map, increasing), `distance_m` float32
// [maps][theta][phi] (metres along the ray to the first surface; +inf where there is none, as in
// open sky), `confidence` uint8 [maps][theta][phi] (0 = unknown, 255 = certain). Both are stored
// contiguously and laid out as the rays are; width and height may be smaller than the panorama's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {

// The root attribute `format` of distances/<id>.h5.
inline constexpr const char* kDistanceVolumeFormat = "raywalk-distances";
// The root attribute `origin` of distances that were packed with the room; others name the method
// that estimated them. Files without the attribute were packed.
inline constexpr const char* kGivenOrigin = "given";

// Distances of less confidence are more often wrong than right (raywalk-build-lf depth --truth
// shows it): views do without them.
inline constexpr std::uint8_t kMinConfidence = 64;

class DistanceVolume {
 public:
  DistanceVolume() = default;  // no maps

  // Maps the file read-only. Throws Error naming the file when it is missing, not HDF5, cut short,
  // of a newer format version, misshapen, or names a station the line does not have.
  static DistanceVolume open(const std::filesystem::path& file, int stations_of_line);

  // The maps of some of the line's stations alone (increasing), which count from 0 on; the mapping
  // is shared.
  DistanceVolume subset(std::span<const int> stations_of_line) const;

  int maps() const { return static_cast<int>(stations_.size()); }
  // Station index of each map, increasing.
  std::span<const int> stations() const { return stations_; }
  PanoramaSize size() const { return size_; }
  // Whether the maps were packed with the room, and not estimated from it.
  bool given() const { return given_; }
  // One column of a map, height values top to bottom; `map` in [0, maps), `theta` in [0, width).
  std::span<const float> distance_column(int map, int theta) const {
    return {static_cast<const float*>(distance_->data()) + offset(map, theta), rows()};
  }
  std::span<const std::uint8_t> confidence_column(int map, int theta) const {
    return {static_cast<const std::uint8_t*>(confidence_->data()) + offset(map, theta), rows()};
  }

 private:
  size_t rows() const { return static_cast<size_t>(size_.height); }
  size_t offset(int map, int theta) const {
    return (static_cast<size_t>(stored_[static_cast<size_t>(map)]) *
                static_cast<size_t>(size_.width) +
            static_cast<size_t>(theta)) *
           rows();
  }

  std::vector<int> stations_;
  std::vector<int> stored_;  // of each map, its index in the file
  PanoramaSize size_;
  bool given_ = false;
  std::shared_ptr<const MappedDataset> distance_;
  std::shared_ptr<const MappedDataset> confidence_;
};

}  // namespace raywalk
