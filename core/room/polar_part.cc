#include "core/room/polar_part.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raywalk {

PolarColumns polar_columns(PanoramaSize size) {
  PolarColumns polar;
  for (int k = 0; k < PolarColumns::kMaxDoublings; ++k) {
    const int step = 2 << k;
    if (size.width % step != 0) break;
    polar.rows[k] = static_cast<int>(std::asin(0.5 / step) / std::numbers::pi * size.height);
  }
  return polar;
}

PolarPart::PolarPart(PanoramaSize size) : size_(size) {
  layout_.polar = polar_columns(size);
  layout_.stride[0] = column_bytes();
  const auto& within = layout_.polar.rows;
  std::int32_t end = column_bytes() * size.width;
  for (int doublings = 1; doublings <= PolarColumns::kMaxDoublings; ++doublings) {
    Level& level = levels_[static_cast<std::size_t>(doublings)];
    const int from = doublings < PolarColumns::kMaxDoublings ? within[doublings] : 0;
    const int to = within[doublings - 1];
    // A sample reads its upper row and the next one.
    level = {.begin = end, .end = end, .first_row = from, .rows = to > from ? to - from + 1 : 0};
    const std::int32_t stride = 2 * 3 * level.rows;
    level.end += stride * (size.width >> doublings);
    end = level.end;
    layout_.stride[doublings] = stride;
    layout_.north[doublings] = level.begin - 3 * level.first_row;
    layout_.south[doublings] = level.begin + 3 * (level.rows - first_southern_row(level));
  }
  const std::int32_t part_bytes = end - column_bytes() * size.width;
  columns_ = (part_bytes + column_bytes() - 1) / column_bytes();
}

RayLayout PolarPart::layout_without() const {
  RayLayout layout{.polar = layout_.polar};
  for (int doublings = 0; doublings <= PolarColumns::kMaxDoublings; ++doublings) {
    layout.stride[doublings] = column_bytes() << doublings;
  }
  return layout;
}

void PolarPart::fill(std::span<const std::uint8_t> rays, std::span<std::uint8_t> part) const {
  auto out = part.begin();
  for (int doublings = 1; doublings <= PolarColumns::kMaxDoublings; ++doublings) {
    const Level& level = levels_[static_cast<std::size_t>(doublings)];
    if (level.rows == 0) continue;
    for (int u = 0; u < size_.width; u += 1 << doublings) {
      for (const int row : {level.first_row, first_southern_row(level)}) {
        const auto from = static_cast<std::size_t>(column_bytes()) * static_cast<std::size_t>(u) +
                          3 * static_cast<std::size_t>(row);
        out = std::ranges::copy(rays.subspan(from, 3 * static_cast<std::size_t>(level.rows)), out)
                  .out;
      }
    }
  }
  std::fill(out, part.end(), std::uint8_t{0});
}

std::vector<PolarPart::Picture> PolarPart::pictures() const {
  std::vector<Picture> pictures;
  for (int doublings = 1; doublings <= PolarColumns::kMaxDoublings; ++doublings) {
    const int rows = levels_[static_cast<std::size_t>(doublings)].rows;
    if (rows > 0) pictures.push_back({size_.width >> doublings, 2 * rows});
  }
  return pictures;
}

RayPlace PolarPart::place_of(std::int32_t offset) const {
  if (offset < column_bytes() * size_.width) {
    return {offset / column_bytes(), offset % column_bytes() / 3};
  }
  int doublings = 1;
  while (offset >= levels_[static_cast<std::size_t>(doublings)].end) ++doublings;
  const Level& level = levels_[static_cast<std::size_t>(doublings)];
  const std::int32_t within = offset - level.begin;
  const std::int32_t stride = layout_.stride[doublings];
  const int row = within % stride / 3;
  return {within / stride << doublings,
          row < level.rows ? level.first_row + row : first_southern_row(level) + row - level.rows};
}

}  // namespace raywalk
