// Writes what the engine computes for random grids and viewpoints, for the page's unit tests to
// compare with: viewer_geometry_cases FILE
#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/view/view_height.h"
#include "core/view/view_plan.h"
#include "render/web/web_manifest.h"

namespace raywalk::render {
namespace {

using nlohmann::ordered_json;

constexpr int kGrids = 40;
constexpr int kViewpoints = 6;  // of each grid
constexpr int kColumns = 90;

class Cases {
 public:
  ordered_json all() {
    ordered_json cases = ordered_json::array();
    for (int i = 0; i < kGrids; ++i) cases.push_back(with_grid(i));
    return cases;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  // A line of unevenly spaced stations that runs slightly askew and up and down.
  void add_line(LineAxis axis, double place_m, double first_m, double last_m,
                std::vector<StationPose>* poses) {
    const double spacing_m = (last_m - first_m) / std::uniform_int_distribution(5, 30)(random_);
    const double slope = between(-0.01, 0.01);
    for (double at_m = first_m; at_m < last_m + 0.5 * spacing_m; at_m += spacing_m) {
      const double along_m = at_m + between(-0.2, 0.2) * spacing_m;
      const double aside_m = place_m + slope * along_m + between(-0.005, 0.005) * spacing_m;
      const double up_m = between(-0.01, 0.01) * spacing_m;
      poses->push_back({.file = std::to_string(poses->size()),
                        .position_m = axis == LineAxis::kX
                                          ? Eigen::Vector3d(along_m, up_m, aside_m)
                                          : Eigen::Vector3d(aside_m, up_m, along_m),
                        .line = (axis == LineAxis::kX ? "x" : "z") + std::to_string(place_m)});
    }
  }

  // Two cells beside each other, or (every fourth grid) a single line, which closes none.
  Grid grid(int index) {
    const double side_m = std::exp(between(std::log(0.1), std::log(10.0)));
    const double over_m = side_m * between(0.0, 0.3);
    std::vector<StationPose> poses;
    if (index % 4 == 3) {
      add_line(LineAxis::kX, 0.0, -side_m, side_m, &poses);
    } else {
      for (const double z_m : {-0.5 * side_m, 0.5 * side_m}) {
        add_line(LineAxis::kX, z_m, -0.5 * side_m - over_m, 1.5 * side_m + over_m, &poses);
      }
      for (const double x_m : {-0.5 * side_m, 0.5 * side_m, 1.5 * side_m}) {
        add_line(LineAxis::kZ, x_m, -0.5 * side_m - over_m, 0.5 * side_m + over_m, &poses);
      }
    }
    return find_grid(poses, {});
  }

  // Within a cell, on its sides and in its corners too.
  PlanPoint viewpoint(const Grid& grid) {
    constexpr std::array kEdges{0.0, 1.0};
    const auto share = [&] {
      return between(0.0, 1.0) < 0.3 ? kEdges[random_() % 2] : between(0.0, 1.0);
    };
    if (grid.cells.empty()) {
      const Line& line = grid.lines.front();
      const double along_m = std::lerp(line.first_m(), line.last_m(), share());
      const double aside_m = 0.1 * (line.last_m() - line.first_m()) * between(-1.0, 1.0);
      return {line.origin.x_m + along_m, line.origin.z_m + aside_m};
    }
    const Cell& cell = grid.cells[random_() % grid.cells.size()];
    return {std::lerp(cell.x_min_m, cell.x_max_m, share()),
            std::lerp(cell.z_min_m, cell.z_max_m, share())};
  }

  static ordered_json sources_json(std::span<const RaySource> sources, int count) {
    ordered_json list = ordered_json::array();
    for (const RaySource& source : sources.first(static_cast<std::size_t>(count))) {
      list.push_back({{"line", source.line},
                      {"station", source.station},
                      {"fraction", source.fraction},
                      {"d_p_m", source.d_p_m},
                      {"weight", source.weight}});
    }
    return list;
  }

  ordered_json with_viewpoint(const Grid& grid) {
    const PlanPoint at = viewpoint(grid);
    const ConnectionRule rule{radians_from_degrees(between(45.0, 90.0)),
                              radians_from_degrees(between(0.0, 20.0))};
    const ViewPlan plan(grid, at, rule);
    ordered_json columns = ordered_json::array();
    for (int i = 0; i < kColumns; ++i) {
      const double theta_rad = (i + 0.5) * kTwoPi / kColumns - kPi;
      const ColumnPlan column = plan.column(theta_rad);
      columns.push_back({{"theta_rad", theta_rad},
                         {"front", sources_json(column.front, column.front_count)},
                         {"behind", sources_json(column.behind, column.behind_count)}});
    }
    return {{"x_m", at.x_m},
            {"z_m", at.z_m},
            {"k_rad", rule.k_rad},
            {"overlap_rad", rule.overlap_rad},
            {"height_m", plan.height_m()},
            {"columns", std::move(columns)}};
  }

  ordered_json with_grid(int index) {
    const Grid made = grid(index);
    ordered_json entry = grid_json(made);
    entry["viewpoints"] = ordered_json::array();
    for (int i = 0; i < kViewpoints; ++i) entry["viewpoints"].push_back(with_viewpoint(made));
    return entry;
  }

  std::mt19937 random_{20};
};

}  // namespace
}  // namespace raywalk::render

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: viewer_geometry_cases FILE\n", stderr);
    return 2;
  }
  std::ofstream file(argv[1]);
  file << raywalk::render::Cases().all();
  file.close();
  return file ? 0 : 1;
}
