#include "core/view/tile_requests.h"

#include <algorithm>

namespace raywalk {
namespace {

// What a sample reads from its upper pixel on, and what vector loads reach around it.
constexpr std::int32_t kReach = 16;

bool any_read(const RowsRead& read, int begin, int end) {
  if (read.weight == nullptr) return true;
  const auto weight_of_row = [&](int row) {
    return read.weight + (read.first_row + row) / read.rows_per_weight;
  };
  return std::any_of(weight_of_row(begin), weight_of_row(end - 1) + 1,
                     [](std::int16_t weight) { return weight != 0; });
}

}  // namespace

void TileRequests::ask(const LineVolume& volume, int station, const SamplePositions& at, int rows,
                       RowsRead read) {
  extents_.resize(static_cast<std::size_t>((rows + kRowsPerExtent - 1) / kRowsPerExtent));
  column_kernels().find_extents(at, rows, extents_.data());
  known_ = {};
  for (int begin = 0; begin < rows; begin += kRowsPerExtent) {
    const int end = std::min(begin + kRowsPerExtent, rows);
    if (!any_read(read, begin, end)) continue;
    const OffsetExtent& extent = extents_[static_cast<std::size_t>(begin / kRowsPerExtent)];
    const std::int32_t* const offsets[] = {at.offset_left, at.offset_right};
    for (const int side : {0, 1}) {
      const OffsetRange& range = side == 0 ? extent.left : extent.right;
      const auto tile = volume.decoded_with(static_cast<std::size_t>(range.least));
      if (static_cast<std::size_t>(range.most) < 2 * tile.end - tile.begin) {
        ask_between(volume, station, side, range.least, range.most);
        continue;
      }
      // The rows jump, as from the columns to the polar part or over a pole.
      for (int row = begin; row < end; ++row) {
        ask_between(volume, station, side, offsets[side][row], offsets[side][row]);
      }
    }
  }
}

void TileRequests::ask_between(const LineVolume& volume, int station, int side, std::int32_t least,
                               std::int32_t most) {
  OffsetRange& known = known_[static_cast<std::size_t>(side)];
  if (known.least <= least && most <= known.most) return;
  if (cubic_) {
    ask_for_cubic(volume, station, side, least, most);
    return;
  }
  volume.require(station, static_cast<std::size_t>(least), static_cast<std::size_t>(most) + kReach);
  const auto tile = volume.decoded_with(static_cast<std::size_t>(least));
  known = {static_cast<std::int32_t>(tile.begin) + kReach,
           static_cast<std::int32_t>(tile.end) - 2 * kReach};
}

void TileRequests::ask_for_cubic(const LineVolume& volume, int station, int side,
                                 std::int32_t least, std::int32_t most) const {
  const std::int32_t column = 3 * volume.panorama().height;
  const std::int32_t all = column * volume.panorama().width;
  // A pixel above and two below, and a column farther out.
  const std::int32_t begin = least - 3 - (side == 0 ? column : 0);
  const std::int32_t end = most + 3 + kReach + (side == 1 ? column : 0);
  const auto require = [&](std::int32_t from, std::int32_t to) {
    if (from >= to) return;
    volume.require(station, static_cast<std::size_t>(from), static_cast<std::size_t>(to));
  };
  require(std::max(begin, 0), std::min(end, all));
  require(all + begin, begin < 0 ? all : 0);  // around the seam
  require(0, end - all);
}

}  // namespace raywalk
