// Whether samples of a station touch rays that are not to be used.
#pragma once

#include <cstdint>

#include "core/room/line_volume.h"

namespace raywalk {

class SampleCheck {
 public:
  // The volume must outlive the check.
  SampleCheck(const LineVolume& volume, int station)
      : volume_(volume), station_(station), column_bytes_(3 * volume.panorama().height) {}

  // Whether all four pixels of a bilinear sample may be used; offsets as in SamplePositions. Quick
  // for samples of a column one after the other, as they mostly lie in the same two columns.
  bool valid(std::int32_t offset_left, std::int32_t offset_right) {
    return left_.valid(*this, offset_left) && right_.valid(*this, offset_right);
  }

 private:
  struct Column {
    std::int32_t offset = -1;  // of its first row; negative: none looked up yet
    RowRun rows;

    bool valid(const SampleCheck& check, std::int32_t sample) {
      if (offset < 0 || sample < offset || sample >= offset + check.column_bytes_) {
        const int theta = sample / check.column_bytes_;
        offset = theta * check.column_bytes_;
        rows = check.volume_.valid_rows(check.station_, theta);
      }
      const int upper = (sample - offset) / 3;
      return upper >= rows.begin && upper + 1 < rows.end;
    }
  };

  const LineVolume& volume_;
  int station_;
  std::int32_t column_bytes_;
  Column left_;
  Column right_;
};

}  // namespace raywalk
