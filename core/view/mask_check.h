// Whether samples of a station touch pixels that must not be used: masked by the user, or left out
// because something moved there.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/room/room.h"

namespace raywalk {

// Whether a station has any such pixels.
inline bool has_masks(const Room& room, int line, int station) {
  return room.volume(line).masked() || room.distances(line).left_out().any(station);
}

// Fast for consecutive samples of a column, which mostly lie in the same columns of the station.
class MaskCheck {
 public:
  // `beyond`: pixels that a sample reads around its 2 x 2, 1 if it is bicubic. The room must
  // outlive the object.
  MaskCheck(const Room& room, int line, int station, int beyond)
      : volume_(room.volume(line)),
        left_out_(room.distances(line).left_out()),
        station_(station),
        beyond_(beyond),
        moved_(left_out_.any(station)) {}

  // Whether all pixels of a sample may be used, and whether they are at least not masked; `left`,
  // `right` as in SamplePlaces.
  bool usable(std::int32_t left, std::int32_t right) { return check(left, right, moved_); }
  bool valid(std::int32_t left, std::int32_t right) { return check(left, right, false); }

 private:
  bool check(std::int32_t left, std::int32_t right, bool moved) {
    const PanoramaSize size = volume_.panorama();
    const int row = left % (3 * size.height) / 3;
    const int first = left / (3 * size.height), last = right / (3 * size.height);
    for (int u = -beyond_; u < 0; ++u) {
      if (!column_usable((first + u + size.width) % size.width, row, moved, 0)) return false;
      if (!column_usable((last - u) % size.width, row, moved, 3)) return false;
    }
    return column_usable(first, row, moved, 1) && column_usable(last, row, moved, 2);
  }

  struct Column {
    int theta = -1;
    RowRun valid{};
    std::span<const LeftOutRun> moved{};
  };

  bool column_usable(int theta, int row, bool moved, std::size_t which) {
    Column& column = columns_[which];
    const PanoramaSize size = volume_.panorama(), maps = left_out_.size();
    if (column.theta != theta) {
      column.theta = theta;
      column.valid = volume_.valid_rows(station_, theta);
      if (moved_) {
        column.moved = left_out_.rows(
            station_, static_cast<int>(static_cast<std::int64_t>(theta) * maps.width / size.width));
      }
    }
    const int first = std::max(row - beyond_, 0);
    const int last = std::min(row + 1 + beyond_, size.height - 1);
    if (first < column.valid.begin || last >= column.valid.end) return false;
    if (!moved) return true;
    const auto in_maps = [&](int at) {
      return static_cast<int>(static_cast<std::int64_t>(at) * maps.height / size.height);
    };
    return std::ranges::none_of(column.moved, [&](const RowRun& run) {
      return in_maps(first) < run.end && in_maps(last) >= run.begin;
    });
  }

  const LineVolume& volume_;
  const LeftOutPixels& left_out_;
  int station_;
  int beyond_;
  bool moved_;
  std::array<Column, 4> columns_{};
};

}  // namespace raywalk
