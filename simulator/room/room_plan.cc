#include "simulator/room/room_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "simulator/room/hash_random.h"

namespace raywalk::capture {
namespace {

constexpr int kStationsPerCell = 40;  // default spacing
constexpr int kMostStationsPerLine = 10000;
constexpr double kClearanceShare = 0.25;  // of the cell's side
constexpr double kLeastHeadroom = 0.25;   // room units, in rooms whose cells are larger than that

// The number of whole steps per cell side that is closest to the requested spacing.
int steps_per_cell(const GridSettings& grid) {
  if (grid.spacing_mm == 0.0) return kStationsPerCell;
  const double steps = std::round(grid.cell_side_m * 1e3 / grid.spacing_mm);
  const double cells = std::max(grid.cells_x, grid.cells_z) + 2.0 * grid.overhang_share;
  if (steps * cells >= kMostStationsPerLine) {
    throw UsageError(fmt::format("grid.spacing_mm is {}: more than {} stations on a line",
                                 grid.spacing_mm, kMostStationsPerLine));
  }
  if (grid.shared_crossings && steps < 3.0) {
    throw UsageError(fmt::format(
        "grid.spacing_mm is {}: lines that share their crossings need at least three steps a cell",
        grid.spacing_mm));
  }
  return std::max(static_cast<int>(steps), 1);
}

PlannedLine planned_line(LineAxis axis, int number, int cells_along, int cells_across,
                         double cell_side, int steps, int overhang_steps, bool with_crossings) {
  PlannedLine line;
  line.id = fmt::format("{}{}", axis == LineAxis::kX ? 'x' : 'z', number);
  line.axis = axis;
  line.across = (number - 0.5 * cells_across) * cell_side;
  for (int i = -overhang_steps; i <= cells_along * steps + overhang_steps; ++i) {
    const bool on_grid = i >= 0 && i <= cells_along * steps;
    if (!with_crossings && on_grid && i % steps == 0) continue;
    line.along.push_back((static_cast<double>(i) / steps - 0.5 * cells_along) * cell_side);
  }
  return line;
}

void plan_lines(const GridSettings& grid, RoomPlan* plan) {
  const int steps = steps_per_cell(grid);
  // The tolerance keeps an exact number of steps from being rounded down.
  const int overhang_steps = static_cast<int>(std::floor(grid.overhang_share * steps + 1e-9));
  plan->overhang = plan->cell_side * overhang_steps / steps;
  for (int i = 0; i <= grid.cells_z; ++i) {
    plan->lines.push_back(planned_line(LineAxis::kX, i, grid.cells_x, grid.cells_z, plan->cell_side,
                                       steps, overhang_steps, true));
  }
  for (int i = 0; i <= grid.cells_x; ++i) {
    plan->lines.push_back(planned_line(LineAxis::kZ, i, grid.cells_z, grid.cells_x, plan->cell_side,
                                       steps, overhang_steps, !grid.shared_crossings));
  }
}

struct Span {
  double min = 0.0;
  double max = 0.0;
};

// Positions of two opposite walls. `reach` is the extent of the lines from the grid's middle,
// `given` the distance of the walls in room units, or 0 if the seed chooses it; `size` multiplies
// what it chooses.
Span place_walls(const char* key, double given, double reach, const RoomPlan& plan, double size,
                 HashRandom random) {
  const double behind = size * random.uniform(0.75, 2.1), ahead = size * random.uniform(0.75, 2.1);
  if (given == 0.0) {
    return {-reach - plan.clearance - behind, reach + plan.clearance + ahead};
  }
  const double least = 2.0 * (reach + plan.clearance);
  if (given < least) {
    throw UsageError(fmt::format(
        "{} is {:g}; the lines with their overhang and a quarter of a cell around them need {:g}",
        key, given * plan.unit_m, least * plan.unit_m));
  }
  const double slack = given - least;
  const double min = -reach - plan.clearance - slack * behind / (behind + ahead);
  return {min, min + given};
}

void plan_heights(const RoomSettings& room, double size, HashRandom random, RoomPlan* plan) {
  double camera = random.uniform(1.25, 1.5), above = size * random.uniform(1.0, 1.5);
  if (room.camera_height_m > 0.0) camera = room.camera_height_m / plan->unit_m;
  if (room.height_m > 0.0) {
    const double height = room.height_m / plan->unit_m;
    // If only the room's height is given, the lines are at about half of it.
    if (room.camera_height_m == 0.0) camera = std::min(camera, 0.55 * height);
    above = height - camera;
  }
  if (camera < plan->headroom || above < plan->headroom) {
    throw UsageError(fmt::format(
        "room.camera_height_m is {:g} in a room {:g} m high; the lines need {:g} m above and below "
        "them",
        camera * plan->unit_m, (camera + above) * plan->unit_m, plan->headroom * plan->unit_m));
  }
  plan->walls.y_min = -camera;
  plan->walls.y_max = above;
}

// How much farther than in a small room walls are from the grid: a hall grows with its shorter
// side.
double hall_size(const VirtualRoomSettings& settings) {
  constexpr double kPerCell = 0.2;
  if (settings.place != "hall") return 1.0;
  return 1.0 + kPerCell * (std::min(settings.grid.cells_x, settings.grid.cells_z) - 1);
}

// Metres per room unit.
double unit_of(const VirtualRoomSettings& settings) {
  const double scale_m = settings.room.furniture_scale_m;
  if (scale_m == 0.0) return settings.grid.cell_side_m;
  if (scale_m >= kLeastFurnitureScale_m) return scale_m;
  throw UsageError(
      fmt::format("room.furniture_scale_m is {:g}; use 0 (the cell's side) or {:g} to "
                  "{:g}",
                  scale_m, kLeastFurnitureScale_m, kLargestFurnitureScale_m));
}

}  // namespace

RoomPlan plan_room(const VirtualRoomSettings& settings) {
  const HashRandom random(hash_bits(static_cast<std::uint64_t>(settings.seed)));
  const GridSettings& grid = settings.grid;
  RoomPlan plan;
  plan.seed = settings.seed;
  plan.unit_m = unit_of(settings);
  plan.cell_side = grid.cell_side_m / plan.unit_m;
  plan.cells_x = grid.cells_x;
  plan.cells_z = grid.cells_z;
  plan.clearance = kClearanceShare * plan.cell_side;
  plan.headroom = std::min(plan.clearance, kLeastHeadroom);
  plan_lines(grid, &plan);
  const double size = hall_size(settings);
  const Span x = place_walls("room.width_m", settings.room.width_m / plan.unit_m,
                             plan.grid_half_x() + plan.overhang, plan, size, random.branch(1));
  const Span z = place_walls("room.depth_m", settings.room.depth_m / plan.unit_m,
                             plan.grid_half_z() + plan.overhang, plan, size, random.branch(2));
  plan.walls.x_min = x.min;
  plan.walls.x_max = x.max;
  plan.walls.z_min = z.min;
  plan.walls.z_max = z.max;
  plan_heights(settings.room, 0.5 * (1.0 + size), random.branch(3), &plan);
  plan.truth_cells.resize(static_cast<std::size_t>(grid.cells_x) *
                          static_cast<std::size_t>(grid.cells_z));
  std::iota(plan.truth_cells.begin(), plan.truth_cells.end(), 0);
  return plan;
}

}  // namespace raywalk::capture
