#include "core/evaluate/connect_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/geometry/position_tolerance.h"
#include "core/room/room.h"
#include "core/view/column_sources.h"
#include "core/view/connection.h"
#include "core/view/prepared_view.h"
#include "core/view/renderer.h"

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

// Over output columns of overlaps: the squared differences of all samples of the columns, in
// squared 8-bit levels, and the number of columns.
using OverlapSum = cv::Vec2d;

// Over the samples; NaN where there was no column.
double mean_square(const OverlapSum& sum, int samples_per_column) {
  return sum[1] == 0.0 ? std::nan("") : sum[0] / (sum[1] * samples_per_column);
}

// The corner between a side of a cell and the next one, seen from a viewpoint.
class Corner {
 public:
  Corner(const Grid& grid, const Cell& cell, int side, PlanPoint viewpoint)
      : grid_(grid), cell_(cell), side_(side), viewpoint_(viewpoint) {}

  double normal_rad() const { return side_normal_rad(static_cast<Side>(side_)); }
  // Where the two lines connect, from the normal.
  double cut_rad(double k_deg) const {
    return hybrid_cut(corner_view(grid_, cell_, static_cast<Side>(side_), viewpoint_),
                      radians_from_degrees(k_deg));
  }
  // Whether both lines captured what is in this direction.
  bool captured(double theta_rad) const {
    return captured_by(0, theta_rad) && captured_by(1, theta_rad);
  }
  // Of a column: one of the two lines (0 or 1) in front, and what the plan has behind.
  ColumnPlan plan(const ViewPlan& view, int which, double theta_rad) const {
    ColumnPlan column = view.column(theta_rad);
    const auto intersection = cross(which, theta_rad);
    column.front_count = intersection ? 1 : 0;
    if (intersection) column.front[0] = source_at(line(which), line_index(which), *intersection);
    return column;
  }

 private:
  int line_index(int which) const {
    return cell_.line[static_cast<size_t>((side_ + which) % kCorners)];
  }
  const Line& line(int which) const { return grid_.lines[static_cast<size_t>(line_index(which))]; }
  // Where a ray meets a line in front of the viewpoint.
  std::optional<LineIntersection> cross(int which, double theta_rad) const {
    const auto intersection = cross_line(line(which), viewpoint_, theta_rad);
    return intersection && intersection->d_p_m >= 0.0 ? intersection : std::nullopt;
  }
  bool captured_by(int which, double theta_rad) const {
    const auto intersection = cross(which, theta_rad);
    return intersection && is_captured_at(line(which), intersection->along_m);
  }

  const Grid& grid_;
  const Cell& cell_;
  int side_;
  PlanPoint viewpoint_;
};

// Compares the columns of a corner rendered from each of its lines: the sum of squared differences
// of each column of the part.
std::vector<double> column_differences(const Corner& corner, const ViewOptions& options,
                                       const PanoramaPart& part, PreparedView* view) {
  std::array<cv::Mat, 2> images;
  for (int which = 0; which < 2; ++which) {
    view->look_at(part, [&](double theta_rad) {
      return column_sources(corner.plan(view->plan(), which, theta_rad), options);
    });
    PixelCounts counts;
    cv::Mat1b unread;
    PreparedView::render(std::array{view}, part, nullptr, nullptr,
                         &images.at(static_cast<size_t>(which)), &unread, &counts);
  }
  std::vector<double> differences;
  differences.reserve(static_cast<size_t>(part.columns));
  for (int i = 0; i < part.columns; ++i) {
    differences.push_back(cv::norm(images[0].col(i), images[1].col(i), cv::NORM_L2SQR));
  }
  return differences;
}

// The sums of each k, of the columns that both lines captured.
std::vector<OverlapSum> overlap_sums(const Corner& corner, const ViewOptions& options,
                                     std::span<const double> k_list_deg, PreparedView* view) {
  std::vector<double> cuts_rad;
  cuts_rad.reserve(k_list_deg.size());
  for (const double k_deg : k_list_deg) cuts_rad.push_back(corner.cut_rad(k_deg));
  std::vector<OverlapSum> sums(cuts_rad.size());
  const double half_rad = 0.5 * radians_from_degrees(options.overlap_deg);
  const PanoramaSize output = view->output();
  const double step_rad = kTwoPi / output.width;
  const auto [least, largest] = std::ranges::minmax(cuts_rad);
  // Column u, not wrapped, is at (u + 0.5) step - pi.
  const double from_rad = corner.normal_rad() + kPi;
  const int begin = static_cast<int>(std::ceil((from_rad + least - half_rad) / step_rad - 0.5));
  const int end =
      static_cast<int>(std::floor((from_rad + largest + half_rad) / step_rad - 0.5)) + 1;
  std::vector<std::pair<size_t, int>> compared;  // k, and a column behind `begin`
  for (int u = begin; u < end; ++u) {
    const double angle_rad = (u + 0.5) * step_rad - from_rad;
    if (!corner.captured(angle_rad + corner.normal_rad())) continue;
    for (size_t k = 0; k < cuts_rad.size(); ++k) {
      if (std::fabs(angle_rad - cuts_rad[k]) <= half_rad) compared.emplace_back(k, u - begin);
    }
  }
  if (compared.empty()) return sums;
  const PanoramaPart part{
      .first_column = begin % output.width, .columns = end - begin, .rows = {0, output.height}};
  const std::vector<double> differences = column_differences(corner, options, part, view);
  for (const auto& [k, column] : compared) {
    sums[k] += OverlapSum(differences[static_cast<size_t>(column)], 1.0);
  }
  return sums;
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

ordered_json measure_connect_error(const Room& room, ViewMethod method,
                                   const ConnectErrorOptions& options) {
  require_connect_error_options(options);
  if (room.grid().cells.empty()) {
    throw Error(room.directory().string() +
                ": no four lines of the room close a cell, so there is no connection to measure");
  }
  const ViewOptions view{.method = method, .overlap_deg = options.overlap_deg};
  Renderer renderer(room, view);
  const int per_cell = options.viewpoints * options.viewpoints;
  Progress progress("connect-error " + method_name(method),
                    std::ssize(room.grid().cells) * per_cell, "viewpoints");
  const size_t k_count = options.k_list_deg.size();
  // Over pairs (viewpoint, corner), of each k; those readable at every k; with a column.
  std::vector<OverlapSum> all(k_count), common(k_count);
  std::vector<std::int64_t> readable(k_count);
  std::int64_t pairs = 0, common_pairs = 0;
  for (const Cell& cell : room.grid().cells) {
    for (int i = 0; i < per_cell; ++i) {
      const int row = i / options.viewpoints;
      const double across = (i % options.viewpoints + 0.5) / options.viewpoints;
      const double ahead = (row + 0.5) / options.viewpoints;
      const PlanPoint viewpoint{std::lerp(cell.x_min_m, cell.x_max_m, across),
                                std::lerp(cell.z_min_m, cell.z_max_m, ahead)};
      PreparedView& prepared = renderer.prepare(viewpoint);
      for (int side = 0; side < kCorners; ++side) {
        const std::vector<OverlapSum> pair = overlap_sums(
            Corner(room.grid(), cell, side, viewpoint), view, options.k_list_deg, &prepared);
        const bool at_all = std::ranges::all_of(pair, [](auto& sum) { return sum[1] > 0.0; });
        ++pairs;
        if (at_all) ++common_pairs;
        for (size_t k = 0; k < k_count; ++k) {
          all[k] += pair[k];
          if (at_all) common[k] += pair[k];
          if (pair[k][1] > 0.0) ++readable[k];
        }
      }
      progress.advance();
    }
  }
  const int samples = 3 * size_as_captured(room).height;
  const auto share = [&](std::int64_t some) { return static_cast<double>(some) / pairs; };
  ordered_json rows = ordered_json::array();
  for (size_t k = 0; k < k_count; ++k) {
    rows.push_back({{"connection", connection_at(options.k_list_deg[k])},
                    {"k_deg", options.k_list_deg[k]},
                    {"method", method_name(method)},
                    {"e_connect", mean_square(all[k], samples)},
                    {"e_connect_common", mean_square(common[k], samples)},
                    {"coverage", share(readable[k])}});
  }
  return {{"connection",
           {{"viewpoints", options.viewpoints},
            {"overlap_deg", options.overlap_deg},
            {"common_share", share(common_pairs)},
            {"comparable", share(common_pairs) >= kLeastComparableShare}}},
          {"rows", std::move(rows)}};
}

std::string connect_error_table(const ordered_json& measured) {
  const auto number = [](const ordered_json& of, const char* key) { return of[key].get<double>(); };
  const auto error = [&](const ordered_json& row, const char* key) {
    return std::isnan(number(row, key)) ? "-" : fmt::format("{:.1f}", number(row, key));
  };
  const ordered_json &rows = measured["rows"], &connection = measured["connection"];
  const int viewpoints = connection["viewpoints"];
  std::string text = fmt::format("{} views, {} x {} viewpoints per cell, overlap {:g} degrees\n",
                                 rows.front()["method"].get<std::string>(), viewpoints, viewpoints,
                                 number(connection, "overlap_deg"));
  text += fmt::format("{:>6}  {:<11}  {:>10}  {:>17}  {:>8}\n", "k", "connection", "E_connect",
                      "at pairs common", "coverage");
  for (const ordered_json& row : rows) {
    text += fmt::format("{:>6g}  {:<11}  {:>10}  {:>17}  {:>7.1f}%\n", number(row, "k_deg"),
                        row["connection"].get<std::string>(), error(row, "e_connect"),
                        error(row, "e_connect_common"), 100.0 * number(row, "coverage"));
  }
  return text + fmt::format("{:.1f}% of the corners are readable at every k\n\n",
                            100.0 * number(connection, "common_share"));
}

}  // namespace raywalk
