// For tests and benchmarks: the steps of a corrected view, to be called one by one.
#pragma once

#include <vector>

#include "core/view/column_distances.h"
#include "core/view/column_mixing.h"
#include "core/view/column_shares.h"
#include "core/view/fill_stations.h"
#include "core/view/hidden_pixels.h"
#include "core/view/renderer.h"
#include "core/view/row_readings.h"
#include "core/view/sample_reader.h"
#include "core/view/source_visibility.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

// Steps that use each other, as ColumnRenderer has them.
struct ViewSteps {
  // `view` has distances and must outlive the object.
  explicit ViewSteps(const ViewInputs& view)
      : reader(view.room, view.interpolation, view.touched, view.gains),
        positions(view),
        distances(view),
        fill(view),
        visibility(view, distances, positions, fill),
        weights(view, visibility, positions, distances.mapping()),
        readings(view, positions, distances.mapping()),
        mixing(view, distances, positions, reader),
        hidden(view, distances.mapping(), positions, fill, reader) {}
  ViewSteps(const ViewSteps&) = delete;
  ViewSteps& operator=(const ViewSteps&) = delete;

  SampleReader reader;
  StationPositions positions;
  ColumnDistances distances;
  FillStations fill;
  SourceVisibility visibility;
  ColumnWeights weights;
  RowReadings readings;
  ColumnMixing mixing;
  HiddenPixels hidden;
};

// A prepared view and its steps.
struct PreparedSteps {
  enum class Bytes { kIgnored, kCounted };

  // The room must outlive the object.
  PreparedSteps(const Room& room, const ViewOptions& options, const Viewpoint& at,
                Bytes bytes = Bytes::kIgnored)
      : renderer(room, options), view(prepared(at, bytes)), steps(view) {}

  // The lines that output column `u` is read from.
  std::vector<RaySource> sources(int u) const {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, view.output).theta_rad;
    return renderer.sources(view.plan.column(theta_rad));
  }

  Renderer renderer;
  const ViewInputs& view;
  ViewSteps steps;

 private:
  const ViewInputs& prepared(const Viewpoint& at, Bytes bytes) {
    renderer.count_bytes(bytes == Bytes::kCounted);
    return renderer.prepare(at).inputs();
  }
};

}  // namespace raywalk
