#include "simulator/room/truth_viewpoints.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"
#include "core/files/csv.h"
#include "simulator/room/hash_random.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;

// A position in a cell, (x, z) from its centre in units of its side.
struct InCell {
  std::string name;
  Vector2d at;
};

// `step` is the spacing of stations in units of the cell's side.
std::vector<InCell> hard_cases(double step, HashRandom* random) {
  const double side = random->chance(0.5) ? 0.45 : -0.45;
  const double half_steps = std::floor(0.5 / step);
  // Whole steps from the corner, well inside of the line.
  const auto on_line = [&] {
    return -0.5 + step * std::floor(half_steps * (0.5 + random->uniform()));
  };
  return {{"centre", {0.0, 0.0}},
          {"quarter_pp", {0.25, 0.25}},
          {"corner", {side, random->chance(0.5) ? 0.45 : -0.45}},
          {"edge_front", {random->uniform(-0.3, 0.3), 0.45}},
          {"line_front_between", {on_line() + 0.5 * step, 0.5}},
          {"quarter_mm", {-0.25, -0.25}},
          {"edge_left", {-0.45, random->uniform(-0.3, 0.3)}},
          {"line_left_on", {-0.5, on_line()}},
          {"quarter_pm", {0.25, -0.25}},
          {"quarter_mp", {-0.25, 0.25}}};
}

// Stratified over a grid of 3 x 3 strata, visited in a fixed scattered order.
Vector2d free_place(int number, HashRandom* random) {
  constexpr int kStrata = 3;
  const int stratum = (number * 5 + 2) % (kStrata * kStrata);
  const int column = stratum % kStrata, row = stratum / kStrata;
  const Vector2d corner(column, row);
  const double in_row = random->uniform();
  const double in_column = random->uniform();
  return (corner + Vector2d(in_column, in_row)) / kStrata - Vector2d(0.5, 0.5);
}

Eigen::Vector3d in_world(const RoomPlan& plan, int cell, const Vector2d& in_cell) {
  const int column = cell % plan.cells_x, row = cell / plan.cells_x;
  const Vector2d at_m = plan.unit_m * plan.cell_side * (plan.cell_centre(column, row) + in_cell);
  return {at_m.x(), 0.0, at_m.y()};
}

// Along a single line there are no cells: viewpoints between its stations, every second one beside
// the line by up to a tenth of the way to the next station.
std::vector<TruthViewpoint> between_stations(const RoomPlan& plan, int count, HashRandom* random) {
  const PlannedLine& line = plan.lines.front();
  const int gaps = static_cast<int>(line.along.size()) - 1;
  std::vector<TruthViewpoint> viewpoints;
  for (int i = 0; i < count; ++i) {
    const auto gap = static_cast<std::size_t>((static_cast<long>(i) * gaps + gaps / 2) / count);
    const double from = line.along[gap], step = line.along[gap + 1] - from;
    const double along = from + random->uniform(0.3, 0.7) * step;
    const double beside = random->uniform(-0.1, 0.1) * step;
    Eigen::Vector3d at = line.position(along);
    if (i % 2 == 1) (line.axis == LineAxis::kX ? at.z() : at.x()) += beside;
    viewpoints.push_back(
        {fmt::format("{}_{:03}", i % 2 == 1 ? "beside" : "between", i), plan.unit_m * at});
  }
  return viewpoints;
}

}  // namespace

std::vector<TruthViewpoint> truth_viewpoints(const RoomPlan& plan, int count) {
  HashRandom random(hash_bits(static_cast<std::uint64_t>(plan.seed), 0x7127));
  if (plan.lines.size() == 1) return between_stations(plan, count, &random);
  const auto& along = plan.lines.front().along;
  const std::vector<InCell> hard = hard_cases((along[1] - along[0]) / plan.cell_side, &random);
  const int cells = static_cast<int>(plan.truth_cells.size());
  const int first_cell = random.below(cells);
  std::vector<TruthViewpoint> viewpoints;
  for (int i = 0; i < count; ++i) {
    const int cell = plan.truth_cells[static_cast<std::size_t>((first_cell + i) % cells)];
    const int number = i - static_cast<int>(hard.size());
    if (number < 0) {
      const InCell& place = hard[static_cast<std::size_t>(i)];
      viewpoints.push_back({place.name, in_world(plan, cell, place.at)});
    } else {
      viewpoints.push_back(
          {fmt::format("free_{:03}", number), in_world(plan, cell, free_place(number, &random))});
    }
  }
  return viewpoints;
}

std::vector<TruthViewpoint> read_truth_viewpoints(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::read(file, {"name", "x", "z"}, {"y"});
  const std::vector<std::string> names = file_names_of_rows(table, "name");
  std::vector<TruthViewpoint> viewpoints;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double y_m = table.has_column("y") ? table.number(row, "y") : 0.0;
    viewpoints.push_back({names[row], {table.number(row, "x"), y_m, table.number(row, "z")}});
  }
  if (viewpoints.empty()) {
    throw Error(file.string() + ": no viewpoints; give at least one line name,x,z");
  }
  return viewpoints;
}

}  // namespace raywalk::capture
