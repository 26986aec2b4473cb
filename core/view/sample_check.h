// Whether samples of a station touch masked rays, or pixels that are left out.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/room/left_out.h"
#include "core/room/line_volume.h"

namespace raywalk {

// The pixel of an offset of SamplePositions. Fast for consecutive samples of a column, which mostly
// lie in the same column of the station.
class PlaceOfSamples {
 public:
  // Whether the sample is in another column than the last one.
  bool move_to(const LineVolume& volume, std::int32_t sample) {
    if (sample >= begin_ && sample < end_) {
      row_ = (sample - begin_) / 3;
      return false;
    }
    const RayPlace at = volume.polar_part().place_of(sample);
    const bool moved = at.column != column_;
    row_ = at.row;
    column_ = at.column;
    const std::int32_t column_bytes = 3 * volume.panorama().height;
    begin_ = at.column * column_bytes;
    end_ = begin_ + column_bytes;
    return moved;
  }
  int column() const { return column_; }
  int row() const { return row_; }

 private:
  std::int32_t begin_ = 0, end_ = 0;  // offsets of the column; none at first
  int column_ = -1;
  int row_ = 0;
};

class SampleCheck {
 public:
  // The volume must outlive the check.
  SampleCheck(const LineVolume& volume, int station)
      : volume_(volume), station_(station), column_bytes_(3 * volume.panorama().height) {}

  // Whether all four pixels of a bilinear sample are unmasked; offsets as in SamplePositions. Fast
  // for consecutive samples of a column, which mostly lie in the same two columns.
  bool valid(std::int32_t offset_left, std::int32_t offset_right) {
    return left_.valid(*this, offset_left) && right_.valid(*this, offset_right);
  }
  // The same for all 4 x 4 pixels of a cubic sample.
  bool valid_around(std::int32_t offset_left, std::int32_t offset_right) {
    const std::int32_t bytes = column_bytes_ * volume_.panorama().width;
    const std::int32_t before = offset_left - column_bytes_;
    const std::int32_t after = offset_right + column_bytes_;
    return left_.valid(*this, offset_left, 1) && right_.valid(*this, offset_right, 1) &&
           before_.valid(*this, before < 0 ? before + bytes : before, 1) &&
           after_.valid(*this, after >= bytes ? after - bytes : after, 1);
  }

 private:
  struct Column {
    PlaceOfSamples place;
    RowRun rows{};

    // `beyond`: number of further rows read above and below the sample's two, within the panorama.
    bool valid(const SampleCheck& check, std::int32_t sample, int beyond = 0) {
      if (place.move_to(check.volume_, sample)) {
        rows = check.volume_.valid_rows(check.station_, place.column());
      }
      const int upper = place.row();
      const int last = check.volume_.panorama().height - 1;
      return std::max(upper - beyond, 0) >= rows.begin &&
             std::min(upper + 1 + beyond, last) < rows.end;
    }
  };

  const LineVolume& volume_;
  int station_;
  std::int32_t column_bytes_;
  Column left_;
  Column right_;
  Column before_;  // the one before the left, and the one after the right
  Column after_;
};

// Whether samples of a station touch pixels that are left out. Fast for consecutive samples of a
// column.
class LeftOutCheck {
 public:
  // The pixels, of the volume's line, and the volume must outlive the check.
  LeftOutCheck(const LeftOutPixels& pixels, const LineVolume& volume, int station)
      : pixels_(pixels), volume_(volume), station_(station) {}

  // Whether all four pixels of a bilinear sample may be used; offsets as in SamplePositions.
  bool valid(std::int32_t offset_left, std::int32_t offset_right) {
    return left_.valid(*this, offset_left) && right_.valid(*this, offset_right);
  }

 private:
  struct Column {
    PlaceOfSamples place;
    std::span<const RowRun> runs{};

    bool valid(const LeftOutCheck& check, std::int32_t sample) {
      const PanoramaSize size = check.pixels_.size();
      const PanoramaSize captured = check.volume_.panorama();
      if (place.move_to(check.volume_, sample)) {
        const std::int64_t theta = place.column();
        runs = check.pixels_.rows(check.station_,
                                  static_cast<int>(theta * size.width / captured.width));
      }
      if (runs.empty()) return true;
      const std::int64_t upper = place.row();
      const auto row_of = [&](std::int64_t row) {
        return static_cast<int>(row * size.height / captured.height);
      };
      const int first = row_of(upper);
      const int last = row_of(upper + 1);
      return std::ranges::none_of(
          runs, [=](const RowRun& run) { return first < run.end && last >= run.begin; });
    }
  };

  const LeftOutPixels& pixels_;
  const LineVolume& volume_;
  int station_;
  Column left_;
  Column right_;
};

}  // namespace raywalk
