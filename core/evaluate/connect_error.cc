#include "core/evaluate/connect_error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/fingerprint.h"
#include "core/geometry/position_tolerance.h"
#include "core/room/room.h"
#include "core/view/column_sources.h"
#include "core/view/connection.h"
#include "core/view/prepared_view.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr int kCorners = 4;
constexpr int kMaxConnectViewpoints = 250;
// The least share of pairs readable at every k whose errors speak for the room: with less, most of
// its corners are not compared at all.
constexpr double kLeastComparableShare = 0.5;

const char* connection_at(double k_deg) {
  if (k_deg == 45.0) return "lfu";
  return k_deg == 90.0 ? "rayspace360" : "hybrid";
}

// An output column in the overlap of a corner.
struct OverlapColumn {
  int u = 0;                        // not wrapped
  double angle_rad = 0.0;           // from the normal of the corner's first side
  double squared_difference = 0.0;  // sum over the column's samples
};

// Over output columns of overlaps.
struct OverlapSum {
  double squared_difference = 0.0;  // of all samples of the columns, in squared 8-bit levels
  std::int64_t columns = 0;

  void add(const OverlapSum& other) {
    squared_difference += other.squared_difference;
    columns += other.columns;
  }
  // Over the samples; NaN where there was no column.
  double mean(int samples_per_column) const {
    if (columns == 0) return std::numeric_limits<double>::quiet_NaN();
    return squared_difference / (static_cast<double>(columns) * samples_per_column);
  }
};

// Over pairs (viewpoint, corner), at one k.
struct SumsAtK {
  OverlapSum all{};
  OverlapSum common{};     // over the pairs that are readable at every k
  std::int64_t pairs = 0;  // with a column
};

// Measures one cell, viewpoint by viewpoint.
class CellMeasurement {
 public:
  CellMeasurement(const Room& room, const Cell& cell, const ViewOptions& view,
                  const ConnectErrorOptions& options)
      : room_(room), cell_(cell), view_(view), options_(options), output_(size_as_captured(room)) {}

  // The centre of a sub-cell.
  PlanPoint viewpoint(int index) const {
    const int n = options_.viewpoints;
    const int row = index / n;
    const double across = (index % n + 0.5) / n;
    const double ahead = (row + 0.5) / n;
    return {std::lerp(cell_.x_min_m, cell_.x_max_m, across),
            std::lerp(cell_.z_min_m, cell_.z_max_m, ahead)};
  }

  // The sums of each corner (outer) and k (inner) at the viewpoint of a view.
  std::vector<OverlapSum> overlap_sums(PreparedView* view) const {
    std::vector<OverlapSum> sums;
    for (int corner = 0; corner < kCorners; ++corner) {
      const std::vector<double> cuts_rad = cuts(view->plan().viewpoint(), corner);
      std::vector<OverlapColumn> columns =
          overlap_columns(view->plan().viewpoint(), corner, cuts_rad);
      if (!columns.empty()) compare_lines(corner, view, columns);
      for (const double cut_rad : cuts_rad) {
        OverlapSum& sum = sums.emplace_back();
        for (const OverlapColumn& column : columns) {
          if (in_overlap(column.angle_rad, cut_rad)) sum.add({column.squared_difference, 1});
        }
      }
    }
    return sums;
  }

 private:
  double half_overlap_rad() const { return 0.5 * radians_from_degrees(options_.overlap_deg); }

  bool in_overlap(double angle_rad, double cut_rad) const {
    return std::fabs(angle_rad - cut_rad) <= half_overlap_rad();
  }

  // Where the lines of a corner connect, for each k of the list.
  std::vector<double> cuts(PlanPoint viewpoint, int corner) const {
    const CornerView view = corner_view(room_.grid(), cell_, static_cast<Side>(corner), viewpoint);
    std::vector<double> cuts_rad;
    for (const double k_deg : options_.k_list_deg) {
      cuts_rad.push_back(hybrid_cut(view, radians_from_degrees(k_deg)));
    }
    return cuts_rad;
  }

  // All columns that any k of the list compares at a corner: both lines captured them.
  std::vector<OverlapColumn> overlap_columns(PlanPoint viewpoint, int corner,
                                             std::span<const double> cuts_rad) const {
    std::vector<OverlapColumn> columns;
    const double step_rad = kTwoPi / output_.width;
    const double normal_rad = side_normal_rad(static_cast<Side>(corner));
    const auto [least, largest] = std::ranges::minmax(cuts_rad);
    // Column u is at (u + 0.5) step - pi.
    const double first_rad = normal_rad + kPi + least - half_overlap_rad();
    const double last_rad = normal_rad + kPi + largest + half_overlap_rad();
    const int last_u = static_cast<int>(std::floor(last_rad / step_rad - 0.5));
    for (int u = static_cast<int>(std::ceil(first_rad / step_rad - 0.5)); u <= last_u; ++u) {
      const double angle_rad = (u + 0.5) * step_rad - kPi - normal_rad;
      const auto near_cut = [&](double cut_rad) { return in_overlap(angle_rad, cut_rad); };
      const auto captured = [&](int side) {
        const auto crossing = cross(side, viewpoint, angle_rad + normal_rad);
        return crossing && is_captured_at(line_of(side), crossing->along_m);
      };
      if (std::ranges::any_of(cuts_rad, near_cut) && captured(corner) && captured(corner + 1)) {
        columns.push_back({.u = u, .angle_rad = angle_rad});
      }
    }
    return columns;
  }

  int line_index(int side) const { return cell_.line[static_cast<size_t>(side % kCorners)]; }
  const Line& line_of(int side) const {
    return room_.grid().lines[static_cast<size_t>(line_index(side))];
  }

  // Where a column meets a side's line in front of the viewpoint.
  std::optional<LineCrossing> cross(int side, PlanPoint viewpoint, double theta_rad) const {
    const auto crossing = cross_line(line_of(side), viewpoint, theta_rad);
    return crossing && crossing->d_p_m >= 0.0 ? crossing : std::nullopt;
  }

  // A side's line, and what the plan has behind the viewpoint.
  ColumnSources sources(const ViewPlan& plan, int side, double theta_rad) const {
    ColumnPlan column = plan.column(theta_rad);
    const auto crossing = cross(side, plan.viewpoint(), theta_rad);
    column.front_count = crossing ? 1 : 0;
    if (crossing) column.front[0] = source_at(line_of(side), line_index(side), *crossing);
    return column_sources(column, view_);
  }

  // Renders the columns of a corner from each of its lines and compares the two.
  void compare_lines(int corner, PreparedView* view, std::span<OverlapColumn> columns) const {
    const int first = columns.front().u;
    const PanoramaPart part{.first_column = first % output_.width,
                            .columns = columns.back().u + 1 - first,
                            .rows = {0, output_.height}};
    std::array<cv::Mat, 2> images;
    for (int which = 0; which < 2; ++which) {
      view->look_at(
          part, [&](double theta_rad) { return sources(view->plan(), corner + which, theta_rad); });
      PixelCounts counts;
      cv::Mat1b unread;
      PreparedView::render(std::array{view}, part, &images[static_cast<size_t>(which)], &unread,
                           &counts);
    }
    for (OverlapColumn& column : columns) {
      column.squared_difference = cv::norm(images[0].col(column.u - first),
                                           images[1].col(column.u - first), cv::NORM_L2SQR);
    }
  }

  const Room& room_;
  const Cell& cell_;
  const ViewOptions& view_;
  const ConnectErrorOptions& options_;
  const PanoramaSize output_;
};

// Numbers that are not finite become null.
ordered_json json_of(const ConnectError& measured) {
  ordered_json rows = ordered_json::array();
  for (const ConnectErrorAtK& row : measured.rows) {
    rows.push_back({{"connection", connection_at(row.k_deg)},
                    {"k_deg", row.k_deg},
                    {"generation", generation_name(measured.generation)},
                    {"e_connect", row.e_connect},
                    {"e_connect_common", row.e_connect_common},
                    {"coverage", row.coverage}});
  }
  return {{"connection",
           {{"viewpoints", measured.options.viewpoints},
            {"overlap_deg", measured.options.overlap_deg},
            {"common_share", measured.common_share},
            {"comparable", measured.common_share >= kLeastComparableShare}}},
          {"rows", rows}};
}

std::string cell_text(double error) {
  return std::isnan(error) ? "-" : fmt::format("{:.1f}", error);
}

}  // namespace

std::vector<double> default_k_list_deg() {
  std::vector<double> list;
  for (int k_deg = 45; k_deg < 70; k_deg += 5) list.push_back(k_deg);
  for (int k_deg = 70; k_deg <= 90; k_deg += 2) list.push_back(k_deg);
  return list;
}

int viewpoints_for(std::size_t cells) {
  constexpr double kMostCells = 24.0, kPerSide = 49.0, kLeast = 2.0;
  const double more = std::max(static_cast<double>(cells) / kMostCells, 1.0);
  return static_cast<int>(std::max(std::round(kPerSide / std::sqrt(more)), kLeast));
}

void require_connect_error_options(const ConnectErrorOptions& options) {
  if (options.viewpoints < 1 || options.viewpoints > kMaxConnectViewpoints) {
    throw UsageError(fmt::format("connect-error: {} viewpoints per side; it must be in 1..{}",
                                 options.viewpoints, kMaxConnectViewpoints));
  }
  if (!(options.overlap_deg > 0.0 && options.overlap_deg <= 45.0)) {
    throw UsageError(
        fmt::format("connect-error: overlap is {} degrees; it must be above 0 and at most 45",
                    options.overlap_deg));
  }
  if (options.k_list_deg.empty()) throw UsageError("connect-error: the list of k is empty");
  for (const double k_deg : options.k_list_deg) {
    if (!(k_deg >= 45.0 && k_deg <= 90.0)) {
      throw UsageError(fmt::format("connect-error: k is {} degrees; it must be in 45..90", k_deg));
    }
  }
}

ConnectError measure_connect_error(const Room& room, Generation generation,
                                   const ConnectErrorOptions& options) {
  require_connect_error_options(options);
  if (room.grid().cells.empty()) {
    throw Error(room.directory().string() +
                ": no four lines of the room close a cell, so there is no connection to measure");
  }
  const ViewOptions view{.generation = generation, .overlap_deg = options.overlap_deg};
  Renderer renderer(room, view);
  const int per_cell = options.viewpoints * options.viewpoints;
  Progress progress("connect-error " + generation_name(generation),
                    std::ssize(room.grid().cells) * per_cell, "viewpoints");
  const size_t k_count = options.k_list_deg.size();
  std::vector<SumsAtK> sums(k_count);
  std::int64_t pairs = 0, common_pairs = 0;
  for (const Cell& of_cell : room.grid().cells) {
    const CellMeasurement cell(room, of_cell, view, options);
    for (int viewpoint = 0; viewpoint < per_cell; ++viewpoint) {
      const std::vector<OverlapSum> of_viewpoint =
          cell.overlap_sums(&renderer.prepare(cell.viewpoint(viewpoint)));
      for (size_t corner = 0; corner < kCorners; ++corner) {
        const auto pair = std::span(of_viewpoint).subspan(corner * k_count, k_count);
        const bool common =
            std::ranges::all_of(pair, [](const OverlapSum& sum) { return sum.columns > 0; });
        ++pairs;
        if (common) ++common_pairs;
        for (size_t k = 0; k < k_count; ++k) {
          sums[k].all.add(pair[k]);
          if (common) sums[k].common.add(pair[k]);
          if (pair[k].columns > 0) ++sums[k].pairs;
        }
      }
      progress.advance();
    }
  }
  const int samples = 3 * size_as_captured(room).height;
  const auto share = [&](std::int64_t some) { return static_cast<double>(some) / pairs; };
  ConnectError result{
      .generation = generation, .options = options, .common_share = share(common_pairs)};
  for (size_t k = 0; k < k_count; ++k) {
    result.rows.push_back({.k_deg = options.k_list_deg[k],
                           .e_connect = sums[k].all.mean(samples),
                           .e_connect_common = sums[k].common.mean(samples),
                           .coverage = share(sums[k].pairs)});
  }
  return result;
}

std::string connect_error_table(const ConnectError& measurement) {
  std::string text =
      fmt::format("{} views, {} x {} viewpoints per cell, overlap {:g} degrees\n",
                  generation_name(measurement.generation), measurement.options.viewpoints,
                  measurement.options.viewpoints, measurement.options.overlap_deg);
  text += fmt::format("{:>6}  {:<11}  {:>10}  {:>17}  {:>8}\n", "k", "connection", "E_connect",
                      "at pairs common", "coverage");
  for (const ConnectErrorAtK& row : measurement.rows) {
    text += fmt::format("{:>6g}  {:<11}  {:>10}  {:>17}  {:>7.1f}%\n", row.k_deg,
                        connection_at(row.k_deg), cell_text(row.e_connect),
                        cell_text(row.e_connect_common), 100.0 * row.coverage);
  }
  return text + fmt::format("{:.1f}% of the corners are readable at every k\n\n",
                            100.0 * measurement.common_share);
}

void add_connect_errors(const Room& room, std::span<const Generation> generations,
                        const ConnectErrorOptions& options, KeptResults* kept,
                        ordered_json* metrics) {
  for (const Generation generation : generations) {
    const std::string key = sha256_hex(fmt::format(
        "{} connect-error {} {} {} {}", room_fingerprint(room), generation_name(generation),
        options.viewpoints, options.overlap_deg, options.k_list_deg));
    if (kept->find(key) == nullptr) {
      kept->keep(key, json_of(measure_connect_error(room, generation, options)));
    }
    const ordered_json& measured = *kept->find(key);
    for (const ordered_json& row : measured["rows"]) (*metrics)["connection_error"].push_back(row);
    ordered_json& connection = (*metrics)["connection"];
    if (connection.is_null()) connection = measured["connection"];
  }
}

}  // namespace raywalk
