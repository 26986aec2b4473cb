// The rays of one line, mapped from `lines/<id>.h5`.
//
// Dataset `rays`: uint8 [station][theta][phi][rgb], stored contiguously; theta index = u (pixel
// column), phi index = v (pixel row, 0 at the top). One output column is one contiguous read. In
// files of format 3 the polar part of a station (polar_part.h) follows its columns, as more
// columns.
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
#include "core/room/polar_part.h"

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

// The intersection of two runs.
inline RowRun common_rows(RowRun a, RowRun b) {
  return {std::max(a.begin, b.begin), std::min(a.end, b.end)};
}

class LineVolume {
 public:
  // Maps the volume read-only. Throws Error naming the file when it is missing, not HDF5,
  // truncated, of a newer format version, or the shape of `rays` is not
  // [stations][width][height][3], with or without the columns of a polar part, or that of
  // `valid_rows` not [stations][width][2].
  static LineVolume open(const std::filesystem::path& file, int stations, PanoramaSize panorama);

  // The rays of a subset of the stations, renumbered from 0 in the order given; the mapping is
  // shared. Each of `stations` must be in [0, stations()).
  LineVolume subset(std::span<const int> stations) const;

  int stations() const { return static_cast<int>(stored_.size()); }
  // A station's index in the file (differs in a subset), and the number of stations in the file.
  int index_in_file(int station) const { return stored_[static_cast<size_t>(station)]; }
  int stations_in_file() const { return static_cast<int>(rays_->shape()[0]); }
  PanoramaSize panorama() const { return panorama_; }
  // height * 3 bytes, RGB, top to bottom. `theta` in [0, width), `station` in [0, stations).
  std::span<const std::uint8_t> column(int station, int theta) const {
    const size_t bytes = column_bytes();
    const size_t index = stored(station) * stored_columns_ + static_cast<size_t>(theta);
    return {static_cast<const std::uint8_t*>(rays_->data()) + index * bytes, bytes};
  }
  // The same columns one after the other, and with the polar part that follows them.
  std::span<const std::uint8_t> columns(int station) const {
    return {column(station, 0).data(), column_bytes() * static_cast<size_t>(panorama_.width)};
  }
  std::span<const std::uint8_t> columns_and_polar_part(int station) const {
    return {column(station, 0).data(), column_bytes() * stored_columns_};
  }

  bool has_polar_part() const { return stored_columns_ > static_cast<size_t>(panorama_.width); }
  const PolarPart& polar_part() const { return polar_part_; }
  // Where the pixels of a station are, as views read them.
  const RayLayout& layout() const { return layout_; }

  // Starts reading bytes of a station's rays from disk, without waiting; `begin` is relative to the
  // station's first column.
  void fetch(int station, std::size_t begin, std::size_t bytes) const {
    rays_->fetch(column(station, 0).data() + begin, bytes);
  }
  // Whether the middle row of a column is in memory (MappedDataset::in_memory).
  bool in_memory(int station, int theta) const {
    return rays_->in_memory(column(station, theta).data() + 3 * (panorama_.height / 2));
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
  size_t column_bytes() const { return 3 * static_cast<size_t>(panorama_.height); }
  const std::int32_t* valid_rows_at(int station, int theta) const {
    const size_t index =
        stored(station) * static_cast<size_t>(panorama_.width) + static_cast<size_t>(theta);
    return static_cast<const std::int32_t*>(valid_rows_->data()) + 2 * index;
  }

  std::shared_ptr<const MappedDataset> rays_;
  std::shared_ptr<const MappedDataset> valid_rows_;  // null without masks
  std::vector<int> stored_;                          // of each station, its index in the file
  PanoramaSize panorama_;
  size_t stored_columns_ = 0;  // of a station, with its polar part
  PolarPart polar_part_;
  RayLayout layout_;
};

}  // namespace raywalk
