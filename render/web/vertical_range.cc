#include "render/web/vertical_range.h"

#include <algorithm>
#include <array>

#include "core/base/interrupt.h"
#include "core/base/pick_evenly.h"
#include "core/view/distance_view.h"
#include "core/view/map_choice.h"
#include "core/view/view_height.h"

namespace raywalk::render {
namespace {

constexpr int kMostCells = 9;
constexpr int kSteps = 10;
constexpr double kHeightStep_m = 0.05;
constexpr double kMoreUnseen = 0.01;  // of a view's pixels

double range_at(const Room& room, const Cell& cell, int distance_maps, DistanceView* view) {
  const PlanPoint centre{0.5 * (cell.x_min_m + cell.x_max_m), 0.5 * (cell.z_min_m + cell.z_max_m)};
  const Eigen::Vector3d at_m(centre.x_m, height_in_cell(room.grid(), cell, centre), centre.z_m);
  const MapSpread spread = map_spread(room.grid(), centre);
  const auto maps =
      nearest_maps(room, cell.line, at_m, spread.gap_m, spread.most_per_line, distance_maps);
  if (maps.empty()) return 0.0;
  const auto unseen_at = [&](double up_m) {
    throw_if_interrupted();
    view->compute(maps, at_m + Eigen::Vector3d(0.0, up_m, 0.0));
    return view->unseen_share();
  };
  const double level = unseen_at(0.0);
  for (int step = 1; step <= kSteps; ++step) {
    const double up_m = step * kHeightStep_m;
    if (std::max(unseen_at(up_m), unseen_at(-up_m)) > level + kMoreUnseen) {
      return (step - 1) * kHeightStep_m;
    }
  }
  return kSteps * kHeightStep_m;
}

}  // namespace

double vertical_range_m(const Room& room, int distance_maps) {
  const auto& cells = room.grid().cells;
  if (cells.empty() || !room.has_distances()) return 0.0;
  DistanceView view(room);
  double range_m = kSteps * kHeightStep_m;
  for (const int i : pick_evenly(static_cast<int>(cells.size()), kMostCells)) {
    range_m =
        std::min(range_m, range_at(room, cells[static_cast<std::size_t>(i)], distance_maps, &view));
  }
  return range_m;
}

}  // namespace raywalk::render
