// The rays of one line, mapped from `lines/<id>.h5` or, where they are compressed, decoded from it
// as they are asked for.
//
// Dataset `rays`: uint8 [station][theta][phi][rgb], stored contiguously, or compressed
// (tiled_rays.h); theta index = u (pixel column), phi index = v (pixel row, 0 at the top).
// One output column is one contiguous read.
//
// Dataset `valid_rows`, only in lines some of whose stations have a mask: int32
// [station][theta][2], stored contiguously; the first valid row of a column, and one past the last.
// Masked objects (dolly, operator) nearly always reach the panorama's border, so one run of valid
// rows per column suffices, and it is fast to look up. If a mask leaves several runs, the longest
// is kept. The volume keeps the captured rays of the other rows, but they must not be used.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/mapped_dataset.h"
#include "core/room/ray_form.h"
#include "core/room/tiled_rays.h"

namespace raywalk {

// The root attribute `format` of lines/<id>.h5.
inline constexpr const char* kLineVolumeFormat = "raywalk-line";

// Rows [begin, end) of a column.
struct RowRun {
  int begin = 0;
  int end = 0;
  bool empty() const { return begin >= end; }
  friend bool operator==(const RowRun&, const RowRun&) = default;
};

class LineVolume {
 public:
  // Maps the volume read-only. Throws Error naming the file when it is missing, not HDF5,
  // truncated, of another format version, or the shape of `rays` is not
  // [stations][width][height][3], or that of `valid_rows` not [stations][width][2].
  static LineVolume open(const std::filesystem::path& file, int stations, PanoramaSize panorama);

  // The rays of a subset of the stations, renumbered from 0 in the order given; the mapping is
  // shared. Each of `stations` must be in [0, stations()).
  LineVolume subset(std::span<const int> stations) const;

  int stations() const { return static_cast<int>(stored_.size()); }
  // A station's index in the file (differs in a subset), and the number of stations in the file.
  int index_in_file(int station) const { return stored_[static_cast<size_t>(station)]; }
  int stations_in_file() const { return stations_in_file_; }
  PanoramaSize panorama() const { return panorama_; }
  const RayForm& form() const { return form_; }
  // Of a compressed line these may be called, and what they return be read, only while a
  // TileReading is alive in the thread (tiled_rays.h); std::logic_error without. They throw Error
  // where what is stored cannot be decoded.
  //
  // height * 3 bytes, RGB, top to bottom. `theta` in [0, width), `station` in [0, stations).
  std::span<const std::uint8_t> column(int station, int theta) const {
    const size_t begin = column_bytes() * static_cast<size_t>(theta);
    return required(station, begin, column_bytes());
  }
  // All columns, one after the other.
  std::span<const std::uint8_t> columns(int station) const {
    return required(station, 0, station_bytes());
  }

  // A station's first ray. Of a compressed line only bytes that were asked for may be read.
  const std::uint8_t* rays(int station) const {
    if (tiles_) return tiles_->rays(static_cast<int>(stored(station)));
    return static_cast<const std::uint8_t*>(rays_->data()) + stored(station) * station_bytes();
  }
  // Asks for bytes [begin, end) of a station's rays, begin < end, and the few around them that
  // vector loads reach, as TiledRays::require does; nothing to do where they are mapped.
  void require(int station, size_t begin, size_t end) const {
    if (tiles_) tiles_->require(static_cast<int>(stored(station)), begin, end);
  }
  // The bytes around a byte of a station that are decoded with it: those of its tile; all where
  // they are mapped.
  TileLayout::Bytes decoded_with(size_t byte) const {
    if (!tiles_) return {0, station_bytes()};
    return tiles_->layout().bytes_of(tiles_->layout().tile_of(byte));
  }
  // Of all columns of a station.
  size_t station_bytes() const { return column_bytes() * static_cast<size_t>(panorama_.width); }

  // Starts reading bytes of a station's rays from disk, without waiting; `begin` is relative to the
  // station's first column.
  void fetch(int station, std::size_t begin, std::size_t bytes) const {
    if (tiles_) {
      tiles_->fetch(static_cast<int>(stored(station)), begin, begin + bytes);
    } else {
      rays_->fetch(rays(station) + begin, bytes);
    }
  }
  // Whether the middle row of a column is in memory (MappedDataset::in_memory), or its tile
  // decoded.
  bool in_memory(int station, int theta) const {
    const size_t byte =
        column_bytes() * static_cast<size_t>(theta) + 3 * static_cast<size_t>(panorama_.height / 2);
    if (tiles_) return tiles_->is_decoded(static_cast<int>(stored(station)), byte);
    return rays_->in_memory(rays(station) + byte);
  }

  // Whether any station has a mask.
  bool masked() const { return valid_rows_ != nullptr; }
  // The valid rows of a column, within [0, height]; the whole column if the line has no masks.
  RowRun valid_rows(int station, int theta) const {
    if (!masked()) return {0, panorama_.height};
    const std::int32_t* run = valid_rows_at(station, theta);
    return {std::max(run[0], 0), std::min(run[1], panorama_.height)};
  }
  // valid_rows() of all columns of a station as stored: [theta][2]; empty if the line has no masks.
  std::span<const std::int32_t> stored_valid_rows(int station) const {
    if (!masked()) return {};
    return {valid_rows_at(station, 0), 2 * static_cast<size_t>(panorama_.width)};
  }

 private:
  size_t stored(int station) const {
    return static_cast<size_t>(stored_[static_cast<size_t>(station)]);
  }
  std::span<const std::uint8_t> required(int station, size_t begin, size_t bytes) const {
    require(station, begin, begin + bytes);
    return {rays(station) + begin, bytes};
  }
  size_t column_bytes() const { return 3 * static_cast<size_t>(panorama_.height); }
  const std::int32_t* valid_rows_at(int station, int theta) const {
    const size_t index =
        stored(station) * static_cast<size_t>(panorama_.width) + static_cast<size_t>(theta);
    return static_cast<const std::int32_t*>(valid_rows_->data()) + 2 * index;
  }

  std::shared_ptr<const MappedDataset> rays_;        // null where they are compressed
  std::shared_ptr<TiledRays> tiles_;                 // null where they are not
  std::shared_ptr<const MappedDataset> valid_rows_;  // null without masks
  std::vector<int> stored_;                          // of each station, its index in the file
  int stations_in_file_ = 0;
  RayForm form_;
  PanoramaSize panorama_;
};

}  // namespace raywalk
