// Pass 4, first part: what a column of the output is read from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "core/view/column_rows.h"
#include "core/view/column_sources.h"
#include "core/view/distance_view.h"
#include "core/view/edges.h"
#include "core/view/exposure.h"
#include "core/view/fill_stations.h"
#include "core/view/row_map.h"
#include "core/view/view_options.h"
#include "core/view/visibility.h"

namespace raywalk {

// All that the columns of one eye's view are made from. References must outlive it.
struct MixedView {
  bool is_initial() const { return options.method == ViewMethod::kInitial; }

  const Room& room;
  const ViewOptions& options;
  DistanceView& distances;
  const Visibility& visibility;
  const Edges& edges;
  const FillStations& fill;
  const Exposure* exposure = nullptr;  // null: all stations agree
  Visibility::Sources sources{};
  PanoramaSize output{};
  RowMap rows{};          // of the output and the distances
  Latitudes latitudes{};  // of the output's rows
};

// A station that a column is read from.
struct ColumnRead {
  std::size_t source = 0;  // index of the column's source
  int line = 0, station = 0;
  StationShare share{};  // of the column
  StationOccluders by{};
  bool has_masks = false;
};

// What is the same in all rows of an output column.
struct MixedColumn {
  int u = 0;
  double theta_rad = 0.0;
  float captured = 0.0f;  // its place in the stations, W to 2 W
  ColumnSources sources{};
  std::vector<ColumnRead> reads{};
  bool any_masks = false;
  // Not in initial views.
  Eigen::Vector3d eye_m{0, 0, 0};
  int nearest = 0, other = 0;  // columns of the distances, on either side of it
  float right = 0.0f;          // how far right of the nearest one it is, -0.5 to 0.5
  const float* trust = nullptr;
  // Of the nearest one, where the processor found them: what is occluded from each source, and
  // edges.
  std::array<const std::uint8_t*, kMaxSources> occluded{};
  std::span<const EdgePixel> edges{};
};

// Column `u` of the output, but occluded and edges; `column` lends its memory.
void prepare_column(const MixedView& view, int u, MixedColumn* column);

}  // namespace raywalk
