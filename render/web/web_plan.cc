#include "render/web/web_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/room/kept_stations.h"
#include "core/view/view_plan.h"

namespace raywalk::render {
namespace {

constexpr int kWidthStep = 4;
constexpr int kBudgetStep = 16;   // by which the budget reduces widths, pixels
constexpr int kLeastWidth = 256;  // below which the budget does not reduce them
constexpr int kCoarseWidth = 256;
// Four maps of this width are two million vertices, which devices of today draw in a few
// milliseconds.
constexpr int kMostDistances = 1024;
constexpr int kWithoutDistances = 8;  // width of distances that say nothing

int rounded_down(double width) { return static_cast<int>(width) / kWidthStep * kWidthStep; }

struct Widths {
  int panorama = 0;
  int distances = 0;
  std::string why{};  // of the panorama's
};

// The stations of each line that views are read from: from the first to the last.
class StationsRead {
 public:
  explicit StationsRead(const Grid& grid)
      : first_(grid.lines.size(), std::numeric_limits<int>::max()), last_(grid.lines.size(), -1) {}

  void add(const RaySource& source) {
    const auto line = static_cast<std::size_t>(source.line);
    first_[line] = std::min(first_[line], source.station);
    last_[line] = std::max(last_[line], source.station + 1);
  }
  int count() const {
    int count = 0;
    for (std::size_t i = 0; i < first_.size(); ++i) count += std::max(0, last_[i] - first_[i] + 1);
    return count;
  }

 private:
  std::vector<int> first_;
  std::vector<int> last_;
};

int stations_of_cell(const Grid& grid, const Cell& cell, const ConnectionRule& rule) {
  // Closer to a side its line is seen so obliquely that a blend of a degree or two spans all of it.
  constexpr std::array kPlaces{0.1, 0.25, 0.5, 0.75, 0.9};
  constexpr int kColumns = 720;
  StationsRead read(grid);
  for (const double x : kPlaces) {
    for (const double z : kPlaces) {
      const ViewPlan plan(grid,
                          {cell.x_min_m + x * (cell.x_max_m - cell.x_min_m),
                           cell.z_min_m + z * (cell.z_max_m - cell.z_min_m)},
                          rule);
      for (int i = 0; i < kColumns; ++i) {
        const ColumnPlan column = plan.column((i + 0.5) * kTwoPi / kColumns - kPi);
        for (int j = 0; j < column.front_count; ++j) read.add(column.front[std::size_t(j)]);
        for (int j = 0; j < column.behind_count; ++j) read.add(column.behind[std::size_t(j)]);
      }
    }
  }
  return read.count();
}

int count_of(const KeptStations& kept) {
  int count = 0;
  for (const auto& line : kept) count += static_cast<int>(line.size());
  return count;
}

Widths wanted_widths(const Room& room, const std::optional<RoomRequirements>& required,
                     const WebDemand& demand) {
  Widths widths{.panorama = rounded_down(room.panorama().width), .why = "as captured"};
  if (required && std::isfinite(required->worth_width_px)) {
    const int worth = rounded_down(std::ceil(required->worth_width_px) + kWidthStep - 1);
    if (worth < widths.panorama) {
      widths.panorama = worth;
      widths.why = "as its distances are accurate enough for no more";
    }
  }
  if (demand.width_px > 0 && demand.width_px < widths.panorama) {
    widths.panorama = rounded_down(demand.width_px);
    widths.why = "as asked for";
  }
  int maps = 0;
  for (std::size_t i = 0; i < room.grid().lines.size(); ++i) {
    maps = std::max(maps, room.distances(static_cast<int>(i)).size().width);
  }
  if (required) maps = std::min(maps, required->distance_width_px);
  widths.distances =
      std::max(rounded_down(std::min({maps, widths.panorama, kMostDistances})), kWithoutDistances);
  return widths;
}

Widths within_budget(const Widths& wanted, int stations, double budget_mb, bool is_thinned) {
  const int least = std::min(kLeastWidth, wanted.panorama);
  const double ratio = static_cast<double>(wanted.distances) / wanted.panorama;
  Widths widths = wanted;
  while (gpu_mb(stations, widths.panorama, widths.distances) > budget_mb) {
    if (widths.panorama == least) {
      throw Error(fmt::format(
          "the {} of the largest cell need {:.0f} MB of GPU memory even {} pixels wide; give that "
          "with --budget-mb{}",
          counted(stations, "station"),
          std::ceil(gpu_mb(stations, widths.panorama, widths.distances)), least,
          is_thinned ? "" : ", or run raywalk-build-lf require, which may leave some out"));
    }
    widths.panorama = std::max(least, (widths.panorama - 1) / kBudgetStep * kBudgetStep);
    widths.distances = std::max(rounded_down(ratio * widths.panorama), kWithoutDistances);
    widths.why = fmt::format("as {:g} MB hold the stations of one cell", budget_mb);
  }
  return widths;
}

std::string summary_of(const WebPlan& plan, const std::optional<RoomRequirements>& required,
                       const std::string& why_width, const std::string& room) {
  const std::string stations =
      required ? fmt::format("{} of {}, as gaps of up to {:.3g} m suffice", plan.stations,
                             plan.captured_stations, required->spacing_m)
               : fmt::format("all {}; raywalk-build-lf require {} reports which suffice",
                             plan.captured_stations, shell_word(room));
  return fmt::format(
      "  stations   {}\n"
      "  panoramas  {} pixels wide, {}\n"
      "  distances  {} pixels wide\n"
      "  GPU memory {:.1f} MB for all, {:.1f} MB for the {} of the largest cell\n",
      stations, plan.width, why_width, plan.distance_width,
      gpu_mb(plan.stations, plan.width, plan.distance_width),
      gpu_mb(plan.resident_stations, plan.width, plan.distance_width),
      counted(plan.resident_stations, "station"));
}

}  // namespace

int coarse_width_of(int width) { return width > kCoarseWidth ? kCoarseWidth : width / 2; }

double gpu_mb(int stations, int width, int distance_width) {
  const double panorama = 0.5 * width * width * 4.0;
  const double coarse = 0.5 * coarse_width_of(width) * coarse_width_of(width) * 4.0;
  const double distances = 0.5 * distance_width * distance_width * 2.0;
  return 1e-6 * stations * (panorama + coarse + distances);
}

int most_stations_of_a_cell(const Grid& grid, const ConnectionRule& rule) {
  int most = 0;
  for (const Cell& cell : grid.cells) most = std::max(most, stations_of_cell(grid, cell, rule));
  if (!grid.cells.empty()) return most;
  for (const Line& line : grid.lines) most += static_cast<int>(line.stations.size());
  return most;
}

WebPlan plan_export(const Room& room, const std::optional<RoomRequirements>& required,
                    const WebDemand& demand) {
  WebPlan plan;
  // With a spacing of 0 all.
  plan.kept =
      needed_stations(room, required ? required->spacing_m : 0.0, Preferred::kWithDistances);
  plan.stations = count_of(plan.kept);
  for (const Line& line : room.grid().lines) {
    plan.captured_stations += static_cast<int>(line.stations.size());
  }
  plan.resident_stations = most_stations_of_a_cell(room.subset(plan.kept).grid(), demand.rule);
  const Widths widths = within_budget(wanted_widths(room, required, demand), plan.resident_stations,
                                      demand.budget_mb, required.has_value());
  plan.width = widths.panorama;
  plan.distance_width = widths.distances;
  plan.summary = summary_of(plan, required, widths.why, escaped(room.directory().string()));
  return plan;
}

}  // namespace raywalk::render
