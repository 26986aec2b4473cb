#include "core/geometry/plausible_size.h"

#include <fmt/format.h>

#include <algorithm>

namespace raywalk {
namespace {

constexpr double kWidestSpacing_m = 2.0;
constexpr double kWidestCell_m = 50.0;

double widest_spacing_m(const Grid& grid) {
  double widest_m = 0.0;
  for (const Line& line : grid.lines) widest_m = std::max(widest_m, median_spacing_m(line));
  return widest_m;
}

double widest_cell_m(const Grid& grid) {
  double widest_m = 0.0;
  for (const Cell& cell : grid.cells) {
    widest_m = std::max({widest_m, cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m});
  }
  return widest_m;
}

}  // namespace

std::optional<std::string> doubt_of_unit(const Grid& grid) {
  const double spacing_m = widest_spacing_m(grid);
  const double cell_m = widest_cell_m(grid);
  if (spacing_m <= kWidestSpacing_m && cell_m <= kWidestCell_m) return std::nullopt;
  const std::string cells =
      grid.cells.empty() ? "" : fmt::format(" and cells up to {:.4g} m wide", cell_m);
  return fmt::format(
      "stations {:.4g} m apart{}: are the positions in another unit, such as millimetres? x, y and "
      "z "
      "are read as metres; divide millimetres by 1000",
      spacing_m, cells);
}

}  // namespace raywalk
