// What all steps of rendering a view share, and what they count.
//
// A column of a view goes through these steps, each with the result of those before it:
//   view_plan.h          the lines and stations it is read from
//   distance_view.h      the distances seen from the viewpoint, once per view
//   column_distances.h   the distances of the column
//   source_visibility.h  which of its points each line sees
//   column_shares.h      the share of each line in each row, and what none sees
//   row_readings.h       which rows are read from which stations, if some may be skipped
//   station_positions.h  where in a station each row is read
//   column_mixing.h      the samples there, mixed
//   hidden_pixels.h      what no line sees, from the stations of fill_stations.h; picture_fill.h
//                        fills the rest
// initial_columns.h renders the columns of initial views, which have no distances.
// column_renderer.h calls them in this order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/room/room.h"
#include "core/view/column_kernels.h"
#include "core/view/distance_view.h"
#include "core/view/view_options.h"
#include "core/view/view_plan.h"

namespace raywalk {

class RoomGains;
class TouchedRays;

// Input shared by all columns of a view. References must outlive the renderers.
struct ViewInputs {
  const Room& room;
  const ViewPlan& plan;
  PanoramaSize output;
  RowRun rows;  // rows to render; others may be left unchanged
  // The remaining members are for depth-corrected views; distances is null in an initial view.
  const DistanceView* distances = nullptr;
  std::optional<LayerSpacing> layers;  // none: correct by the exact distances
  Arithmetic arithmetic = Arithmetic::kFloat;
  // Stations that hidden pixels are filled from, nearest first.
  std::span<const MapStation> fill_maps;
  // As in ViewOptions.
  Interpolation interpolation = Interpolation::kLinear;
  int stations_mixed = 2;
  SecondSide second_side = SecondSide::kBlend;
  double skip_px = 0.0;
  const RoomGains* gains = nullptr;  // null: all are 1
  TouchedRays* touched = nullptr;    // counts the bytes read; null: not counted

  // The centre of the eyes' circle; of a view from one place that place.
  const Eigen::Vector3d& viewpoint_m() const { return plan.eye().centre_m; }
  // The eye of the column in plan direction theta.
  Eigen::Vector3d eye_m(double theta_rad) const { return plan.eye().position_m(theta_rad); }
  // Where the line of a source is met. Its height is that of the lines around the viewpoint, which
  // single stations are off by little.
  AcquisitionPoint acquisition_point(const RaySource& source) const {
    return {static_cast<float>(source.d_p_m), static_cast<float>(-plan.above_lines_m())};
  }
};

// Lines that a column is read from: at most two in front and two behind.
inline constexpr std::size_t kMaxSources = 4;

// How well a row is seen: from 0, not at all, to kSeen.
inline constexpr std::uint8_t kSeen = 255;

// Output rows per row of the distances where sample positions are computed at the distances' rows
// and interpolated between them: 2, 4 or 8. Else 1: every row's position is computed, as always
// with explicit layers or double arithmetic.
int rows_per_distance(const ViewInputs& view);

// Where such interpolated positions find the pixels of a line's stations.
RayLayout layout_of(const ViewInputs& view, int line);

// Counts of work done and skipped. A reading is one line's share of one pixel.
struct WorkCounts {
  std::int64_t samples = 0;      // read from stations
  std::int64_t found = 0;        // samples at a computed position; the others are stored columns
  std::int64_t readings = 0;     // of lines in use
  std::int64_t uncorrected = 0;  // readings without correction: their shift is too small
  std::int64_t one_station = 0;  // readings of one station: the other's influence is too small
  std::int64_t one_side = 0;     // pixels read from one side of the viewpoint though both see them

  WorkCounts& operator+=(const WorkCounts& other) {
    samples += other.samples;
    found += other.found;
    readings += other.readings;
    uncorrected += other.uncorrected;
    one_station += other.one_station;
    one_side += other.one_side;
    return *this;
  }
};

// Counts of pixels by how they were rendered.
struct PixelCounts {
  std::int64_t all = 0;
  std::int64_t filled = 0;     // hidden from the lines in use, read from another station
  std::int64_t stretched = 0;  // seen by no station: taken from the farther neighbour in the column
  std::int64_t empty = 0;      // no line serves the column, or all of it is masked
  WorkCounts work{};

  PixelCounts& operator+=(const PixelCounts& other) {
    all += other.all;
    filled += other.filled;
    stretched += other.stretched;
    empty += other.empty;
    work += other.work;
    return *this;
  }
};

}  // namespace raywalk
