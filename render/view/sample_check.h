// Whether samples of a station touch masked rays.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/room/line_volume.h"

namespace raywalk::render {

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

}  // namespace raywalk::render
