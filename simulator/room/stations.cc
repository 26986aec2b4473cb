#include "simulator/room/stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

constexpr int kStationsPerCell = 40;  // default spacing
constexpr int kMostStationsPerLine = 10000;

// The number of whole steps per cell side that is closest to the requested spacing.
int steps_per_cell(const GridSettings& grid) {
  if (grid.spacing_mm == 0.0) return kStationsPerCell;
  const double steps = std::round(grid.cell_side_m * 1e3 / grid.spacing_mm);
  const double cells = std::max(grid.cells_x, grid.cells_z) + 2.0 * grid.overhang_share;
  if (steps * cells >= kMostStationsPerLine) {
    throw UsageError(fmt::format("grid.spacing_mm is {}: more than {} stations on a line",
                                 grid.spacing_mm, kMostStationsPerLine));
  }
  if (grid.shared_intersections && steps < 3.0) {
    throw UsageError(
        fmt::format("grid.spacing_mm is {}: lines that share their intersections need at least "
                    "three steps a cell",
                    grid.spacing_mm));
  }
  return std::max(static_cast<int>(steps), 1);
}

PlannedLine planned_line(const GridSettings& grid, LineAxis axis, int number) {
  const bool along_x = axis == LineAxis::kX;
  const int cells_along = along_x ? grid.cells_x : grid.cells_z;
  const int cells_across = along_x ? grid.cells_z : grid.cells_x;
  const bool with_intersections = along_x || !grid.shared_intersections || cells_across == 0;
  const int steps = steps_per_cell(grid);
  // The tolerance keeps an exact number of steps from being rounded down.
  const int overhang_steps = static_cast<int>(std::floor(grid.overhang_share * steps + 1e-9));
  PlannedLine line;
  line.id = fmt::format("{}{}", along_x ? 'x' : 'z', number);
  line.axis = axis;
  line.across_m = (number - 0.5 * cells_across) * grid.cell_side_m;
  for (int i = -overhang_steps; i <= cells_along * steps + overhang_steps; ++i) {
    const bool on_grid = i >= 0 && i <= cells_along * steps;
    if (!with_intersections && on_grid && i % steps == 0) continue;
    line.along_m.push_back((static_cast<double>(i) / steps - 0.5 * cells_along) * grid.cell_side_m);
  }
  return line;
}

}  // namespace

std::vector<PlannedLine> plan_lines(const GridSettings& grid) {
  std::vector<PlannedLine> lines;
  // Without cells along x there is a single line, along z.
  for (int i = 0; i <= grid.cells_z && grid.cells_x > 0; ++i) {
    lines.push_back(planned_line(grid, LineAxis::kX, i));
  }
  for (int i = 0; i <= grid.cells_x; ++i) lines.push_back(planned_line(grid, LineAxis::kZ, i));
  return lines;
}

std::vector<RoomStation> room_stations(const VirtualRoomSettings& settings) {
  const HashRandom all(hash_bits(static_cast<std::uint64_t>(settings.seed), 0x57a7));
  std::vector<RoomStation> stations;
  for (const PlannedLine& line : plan_lines(settings.grid)) {
    for (std::size_t i = 0; i < line.along_m.size(); ++i) {
      HashRandom random = all.branch(stations.size());
      RoomStation station;
      station.line = line.id;
      station.name = fmt::format("{}_{:03}", line.id, i);
      station.number = static_cast<int>(i);
      station.nominal.position_m = line.position_m(line.along_m[i]);
      station.gain = std::clamp(1.0 + settings.sensor.gain_spread * random.normal(), 0.25, 4.0);
      station.noise_key = random.bits();
      station.true_pose = station.nominal;
      add_jitter(settings.pose.position_jitter_mm, settings.pose.attitude_jitter_deg,
                 random.branch(0), &station.true_pose);
      stations.push_back(station);
    }
  }
  return stations;
}

}  // namespace raywalk::simulator
