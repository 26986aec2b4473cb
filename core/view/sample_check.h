// Whether samples of a station touch masked rays, or pixels that are left out.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/room/left_out.h"
#include "core/room/line_volume.h"

namespace raywalk {

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
    std::int32_t offset = -1;  // of its first row; negative: none looked up yet
    RowRun rows;

    // `beyond`: number of further rows read above and below the sample's two, within the panorama.
    bool valid(const SampleCheck& check, std::int32_t sample, int beyond = 0) {
      if (offset < 0 || sample < offset || sample >= offset + check.column_bytes_) {
        const int theta = sample / check.column_bytes_;
        offset = theta * check.column_bytes_;
        rows = check.volume_.valid_rows(check.station_, theta);
      }
      const int upper = (sample - offset) / 3;
      const int last = check.column_bytes_ / 3 - 1;
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
  // The pixels must outlive the check; `captured` is the size of the station's panorama.
  LeftOutCheck(const LeftOutPixels& pixels, int station, PanoramaSize captured)
      : pixels_(pixels), station_(station), captured_(captured) {}

  // Whether all four pixels of a bilinear sample may be used; offsets as in SamplePositions.
  bool valid(std::int32_t offset_left, std::int32_t offset_right) {
    return left_.valid(*this, offset_left) && right_.valid(*this, offset_right);
  }

 private:
  struct Column {
    std::int32_t offset = -1;  // of its first row; negative: none looked up yet
    std::span<const RowRun> runs;

    bool valid(const LeftOutCheck& check, std::int32_t sample) {
      const std::int32_t column_bytes = 3 * check.captured_.height;
      const PanoramaSize size = check.pixels_.size();
      if (offset < 0 || sample < offset || sample >= offset + column_bytes) {
        const std::int64_t theta = sample / column_bytes;
        offset = static_cast<std::int32_t>(theta) * column_bytes;
        runs = check.pixels_.rows(check.station_,
                                  static_cast<int>(theta * size.width / check.captured_.width));
      }
      if (runs.empty()) return true;
      const std::int64_t upper = (sample - offset) / 3;
      const auto row_of = [&](std::int64_t row) {
        return static_cast<int>(row * size.height / check.captured_.height);
      };
      const int first = row_of(upper);
      const int last = row_of(upper + 1);
      return std::ranges::none_of(
          runs, [=](const RowRun& run) { return first < run.end && last >= run.begin; });
    }
  };

  const LeftOutPixels& pixels_;
  int station_;
  PanoramaSize captured_;
  Column left_;
  Column right_;
};

}  // namespace raywalk
