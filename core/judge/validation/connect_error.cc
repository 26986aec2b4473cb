#include "core/judge/validation/connect_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/position_tolerance.h"
#include "core/view/column_renderer.h"
#include "core/view/connection.h"
#include "core/view/view_plan.h"

namespace raywalk {
namespace {

constexpr int kCorners = 4;
constexpr int kMaxConnectViewpoints = 250;
constexpr int kColumnsPerTask = 16;

// An output column in the overlap of a corner, and its sources with either line in front.
struct OverlapColumn {
  int corner = 0;
  int u = 0;
  double angle_rad = 0.0;  // from the normal of the corner's first side
  std::array<std::vector<RaySource>, 2> sources{};
  std::uint64_t squared_difference = 0;  // sum over the column's samples
};

// Measures one cell, viewpoint by viewpoint.
class CellMeasurement {
 public:
  CellMeasurement(const Room& room, const Cell& cell, Generation generation,
                  const ConnectErrorOptions& options)
      : room_(room),
        cell_(cell),
        generation_(generation),
        options_(options),
        output_(size_as_captured(room)) {}

  // Size of the views.
  PanoramaSize output() const { return output_; }

  // The centre of a sub-cell.
  PlanPoint viewpoint(int index) const {
    const int n = options_.viewpoints;
    const int row = index / n;
    const double across = (index % n + 0.5) / n;
    const double ahead = (row + 0.5) / n;
    return {std::lerp(cell_.x_min_m, cell_.x_max_m, across),
            std::lerp(cell_.z_min_m, cell_.z_max_m, ahead)};
  }

  // All columns that any k of the list compares at a viewpoint.
  std::vector<OverlapColumn> overlap_columns(const ViewPlan& plan) const {
    std::vector<OverlapColumn> columns;
    const int width = output_.width;
    const double step_rad = kTwoPi / width;
    for (int corner = 0; corner < kCorners; ++corner) {
      const std::vector<double> cuts_rad = cuts(plan.viewpoint(), corner);
      const double normal_rad = side_normal_rad(static_cast<Side>(corner));
      const auto [least, largest] = std::ranges::minmax(cuts_rad);
      // Column u is at (u + 0.5) step - pi.
      const double first_rad = normal_rad + kPi + least - half_overlap_rad();
      const double last_rad = normal_rad + kPi + largest + half_overlap_rad();
      const int last_u = static_cast<int>(std::floor(last_rad / step_rad - 0.5));
      for (int u = static_cast<int>(std::ceil(first_rad / step_rad - 0.5)); u <= last_u; ++u) {
        const double angle_rad = (u + 0.5) * step_rad - kPi - normal_rad;
        const auto near_cut = [&](double cut_rad) { return in_overlap(angle_rad, cut_rad); };
        if (std::ranges::none_of(cuts_rad, near_cut)) continue;
        OverlapColumn column{.corner = corner, .u = u % width, .angle_rad = angle_rad};
        if (find_sources(plan, &column)) columns.push_back(std::move(column));
      }
    }
    return columns;
  }

  // The sums of each corner (outer) and k (inner).
  std::vector<OverlapSum> overlap_sums(PlanPoint viewpoint,
                                       std::span<const OverlapColumn> columns) const {
    std::vector<OverlapSum> sums;
    for (int corner = 0; corner < kCorners; ++corner) {
      for (const double cut_rad : cuts(viewpoint, corner)) {
        OverlapSum& sum = sums.emplace_back();
        for (const OverlapColumn& column : columns) {
          if (column.corner != corner || !in_overlap(column.angle_rad, cut_rad)) continue;
          sum.add_column(column.squared_difference);
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

  // The source of a column on a side's line, if the line was captured where the ray meets it.
  std::optional<RaySource> source_on(int side, PlanPoint viewpoint, double theta_rad) const {
    const int index = cell_.line[static_cast<size_t>(side % kCorners)];
    const Line& line = room_.grid().lines[static_cast<size_t>(index)];
    const auto crossing = cross_line(line, viewpoint, theta_rad);
    const bool held = crossing && crossing->d_p_m >= 0.0 && is_captured_at(line, crossing->along_m);
    return held ? std::optional(source_at(line, index, *crossing)) : std::nullopt;
  }

  // Fills in the sources; false unless both lines captured the column.
  bool find_sources(const ViewPlan& plan, OverlapColumn* column) const {
    const double theta_rad =
        angles_from_pixel({static_cast<double>(column->u), 0.0}, output_).theta_rad;
    for (int which = 0; which < 2; ++which) {
      const auto source = source_on(column->corner + which, plan.viewpoint(), theta_rad);
      if (!source) return false;
      column->sources[static_cast<size_t>(which)].push_back(*source);
    }
    if (generation_ != Generation::kTwoSided) return true;
    const ColumnPlan planned = plan.column(theta_rad);
    for (auto& sources : column->sources) {
      sources.insert(sources.end(), planned.behind.begin(),
                     planned.behind.begin() + planned.behind_count);
    }
    return true;
  }

  const Room& room_;
  const Cell& cell_;
  const Generation generation_;
  const ConnectErrorOptions& options_;
  const PanoramaSize output_;
};

std::uint64_t squared_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  std::uint64_t sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const int difference = int{a[i]} - int{b[i]};
    sum += static_cast<std::uint64_t>(difference * difference);
  }
  return sum;
}

// Renders each column from each line and compares the two.
void compare_lines(const ViewInputs& inputs, std::span<OverlapColumn> columns) {
  const size_t bytes = 3 * static_cast<size_t>(inputs.output.height);
  std::array<std::vector<std::uint8_t>, 2> pixels;
  for (auto& column : pixels) column.resize(bytes + 1);  // ColumnRenderer writes one beyond
  ColumnRenderer renderer(inputs);
  for (OverlapColumn& column : columns) {
    for (size_t which = 0; which < 2; ++which) {
      renderer.render(column.u, column.sources[which], pixels[which].data());
    }
    column.squared_difference =
        squared_difference(std::span(pixels[0]).first(bytes), std::span(pixels[1]).first(bytes));
  }
}

// Collects the sums of viewpoints, which may be measured in parallel.
class Collection {
 public:
  Collection(size_t k_count, std::int64_t viewpoints, const std::string& what)
      : k_count_(k_count), sums_(k_count), progress_(what, viewpoints, "viewpoints") {}

  // The sums of each corner (outer) and k (inner) of one viewpoint.
  void add(std::span<const OverlapSum> viewpoint) {
    {
      const std::scoped_lock lock(mutex_);
      for (size_t corner = 0; corner < kCorners; ++corner) {
        sums_.add_pair(viewpoint.subspan(corner * k_count_, k_count_));
      }
    }
    progress_.advance();
  }
  const ConnectErrorSums& sums() const { return sums_; }

 private:
  size_t k_count_;
  ConnectErrorSums sums_;
  Progress progress_;
  std::mutex mutex_;
};

// An initial view needs no preparation: viewpoints are parallel.
void measure_initial(const Room& room, const CellMeasurement& cell, IndexRange viewpoints,
                     Collection* collection) {
  const int first = static_cast<int>(viewpoints.begin), last = static_cast<int>(viewpoints.end);
  parallel_for(first, last, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const PlanPoint viewpoint = cell.viewpoint(i);
      const ViewPlan plan(room.grid(), viewpoint, {.k_rad = kHalfPi});
      std::vector<OverlapColumn> columns = cell.overlap_columns(plan);
      const ViewInputs inputs{.room = room,
                              .plan = plan,
                              .output = cell.output(),
                              .rows = {0, cell.output().height},
                              .distances = nullptr,
                              .layers = std::nullopt,
                              .fill_maps = {}};
      compare_lines(inputs, columns);
      collection->add(cell.overlap_sums(viewpoint, columns));
    }
  });
}

// Gathering the distances of a viewpoint is parallel itself: columns are parallel, viewpoints are
// not.
void measure_corrected(const CellMeasurement& cell, IndexRange viewpoints, Renderer* renderer,
                       Collection* collection) {
  for (size_t i = viewpoints.begin; i < viewpoints.end; ++i) {
    const PlanPoint viewpoint = cell.viewpoint(static_cast<int>(i));
    const PreparedView& prepared = renderer->prepare(viewpoint);
    std::vector<OverlapColumn> columns = cell.overlap_columns(prepared.plan());
    parallel_for(0, static_cast<int>(columns.size()), kColumnsPerTask, [&](int begin, int end) {
      compare_lines(
          prepared.inputs(),
          std::span(columns).subspan(static_cast<size_t>(begin), static_cast<size_t>(end - begin)));
    });
    collection->add(cell.overlap_sums(viewpoint, columns));
  }
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

ConnectErrorSums measure_connect_error_sums(const Room& room, Generation generation,
                                            const ConnectErrorOptions& options, Block block) {
  require_connect_error_options(options);
  if (room.grid().cells.empty()) {
    throw Error(room.directory().string() +
                ": no four lines of the room close a cell, so there is no connection to measure");
  }
  Renderer renderer(room, {.generation = generation, .overlap_deg = options.overlap_deg});
  const size_t per_cell =
      static_cast<size_t>(options.viewpoints) * static_cast<size_t>(options.viewpoints);
  const IndexRange share = block.share_of(room.grid().cells.size() * per_cell);
  Collection collection(options.k_list_deg.size(), static_cast<std::int64_t>(share.size()),
                        "connect-error " + generation_name(generation));
  for (size_t index = share.begin; index < share.end;) {
    const size_t cell = index / per_cell;
    const size_t end = std::min(share.end, (cell + 1) * per_cell);
    const IndexRange viewpoints{index - cell * per_cell, end - cell * per_cell};
    const CellMeasurement measurement(room, room.grid().cells[cell], generation, options);
    if (generation == Generation::kInitial) {
      measure_initial(room, measurement, viewpoints, &collection);
    } else {
      measure_corrected(measurement, viewpoints, &renderer, &collection);
    }
    index = end;
  }
  return collection.sums();
}

ConnectError connect_error_of(const ConnectErrorSums& sums, const Room& room, Generation generation,
                              const ConnectErrorOptions& options) {
  const int samples = 3 * size_as_captured(room).height;
  const auto pairs = static_cast<double>(sums.pairs);
  ConnectError result{.generation = generation,
                      .options = options,
                      .common_share = static_cast<double>(sums.common_pairs) / pairs};
  for (size_t k = 0; k < options.k_list_deg.size(); ++k) {
    const ConnectErrorSums::AtK& at_k = sums.at_k[k];
    result.rows.push_back({.connection = connection_name(options.k_list_deg[k]),
                           .k_deg = options.k_list_deg[k],
                           .generation = generation,
                           .e_connect = at_k.all.mean(samples),
                           .e_connect_common = at_k.common.mean(samples),
                           .coverage = static_cast<double>(at_k.pairs) / pairs});
  }
  return result;
}

ConnectError measure_connect_error(const Room& room, Generation generation,
                                   const ConnectErrorOptions& options) {
  return connect_error_of(measure_connect_error_sums(room, generation, options), room, generation,
                          options);
}

std::string connect_error_table(std::span<const ConnectError> measurements) {
  std::string text;
  for (const ConnectError& measurement : measurements) {
    text += fmt::format("{} views, {} x {} viewpoints per cell, overlap {:g} degrees\n",
                        generation_name(measurement.generation), measurement.options.viewpoints,
                        measurement.options.viewpoints, measurement.options.overlap_deg);
    text += fmt::format("{:>6}  {:<11}  {:>10}  {:>17}  {:>8}\n", "k", "connection", "E_connect",
                        "at pairs common", "coverage");
    for (const ConnectErrorRow& row : measurement.rows) {
      text += fmt::format("{:>6g}  {:<11}  {:>10}  {:>17}  {:>7.1f}%\n", row.k_deg, row.connection,
                          cell_text(row.e_connect), cell_text(row.e_connect_common),
                          100.0 * row.coverage);
    }
    text += fmt::format("{:.1f}% of the corners are readable at every k\n\n",
                        100.0 * measurement.common_share);
  }
  return text;
}

}  // namespace raywalk
