#include "core/room/connection_model.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/median.h"
#include "core/geometry/line_gaps.h"
#include "core/room/distance_samples.h"

namespace raywalk {
namespace {

constexpr int kSamplesPerMap = 1024;
// The midpoints of five equal parts. Each distance costs time, and the optimum hardly depends on
// their number (5 and 33 quantiles of a box room give the same).
constexpr std::array kShares{0.1, 0.3, 0.5, 0.7, 0.9};
constexpr double kPaperDistance = 1.5;  // in units of N

double mean_side_m(const Grid& grid) {
  double sum_m = 0.0;
  for (const Cell& cell : grid.cells) {
    sum_m += 0.5 * (cell.x_max_m - cell.x_min_m + cell.z_max_m - cell.z_min_m);
  }
  return sum_m / static_cast<double>(grid.cells.size());
}

double median_step_m(const Grid& grid) {
  std::vector<double> steps_m;
  for (const Line& line : grid.lines) steps_m.push_back(covering_spacing(line));
  return median(std::move(steps_m));
}

}  // namespace

CellSampling cell_sampling(const Grid& grid) {
  return {.side_m = mean_side_m(grid), .step_m = median_step_m(grid)};
}

ConnectionModel connection_model(const Room& room) {
  const CellSampling sampling = cell_sampling(room.grid());
  DistanceSamples known = sample_distances(room, kSamplesPerMap);
  if (known.samples.empty()) {
    const double d_src_m = kPaperDistance * sampling.side_m;
    return {connection_error_curve(sampling, {&d_src_m, 1}), false};
  }
  return {connection_error_curve(sampling, distance_quantiles(known.samples, kShares)), true};
}

}  // namespace raywalk
