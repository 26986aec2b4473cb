// Scratch memory of a ColumnRenderer, kept from one column to the next; private to it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/column_renderer.h"
#include "core/view/precise_positions.h"
#include "core/view/sample_reader.h"
#include "core/view/station_visibility.h"
#include "core/view/visibility.h"

namespace raywalk {

// Cached visibility of one column of the distance view for the sources last used with it.
struct ColumnRenderer::DepthColumn {
  struct Visible {
    int line = -1;
    bool behind = false;
    std::vector<std::uint8_t> rows;
  };
  int theta = -1;
  std::vector<Visible> visible;
  std::vector<int> fill;  // index into fill_maps, kUnknown, or kNone
};

struct ColumnRenderer::Scratch {
  static constexpr int kUnknown = -2;
  static constexpr int kNone = -1;

  Scratch(const ViewInputs& view, int depth_rows)
      : latitudes(view.output.height, view.output.height),
        rows_per_distance(raywalk::rows_per_distance(view)),
        polar(polar_columns_of(view)),
        omega(static_cast<size_t>(view.output.height)),
        exact_omega(omega),
        zero_omega(omega),
        samples{PositionArrays(view.output.height), PositionArrays(view.output.height)},
        reader(view.room, view.interpolation, view.touched, view.gains),
        levels(3 * omega.size() + kSampleLookAhead),
        sum(omega.size() * 4),
        row_weight(omega.size()) {
    if (view.arithmetic == Arithmetic::kDouble) {
      precise = std::make_unique<PrecisePositions>(view.output.height);
    }
    if (depth_rows > 0) {
      mapping = std::make_unique<RowMapping>(view.output.height, depth_rows);
      depth_omega.resize(static_cast<size_t>(depth_rows));
      hidden.resize(static_cast<size_t>(depth_rows));
      fill.resize(3 * omega.size() + 1);  // a byte beyond is scratch
      ring = std::make_unique<RingVisibility>(depth_rows);
      stations = std::make_unique<StationVisibility>(
          view.room, *view.distances,
          Eigen::Vector3d(view.plan.viewpoint().x_m, view.plan.height_m(),
                          view.plan.viewpoint().z_m));
      depth_latitudes = std::make_unique<LatitudeTable>(depth_rows, depth_rows);
      needed.resize(static_cast<size_t>(depth_rows));
      most.resize(needed.size());
      seeing.resize(needed.size());
      weight_scale.resize(needed.size());
      if (rows_per_distance > 1) {
        const auto padded = static_cast<size_t>(depth_rows) + kShiftPadding;
        for (auto* shift : {&shift_u, &shift_v}) shift->resize(padded);
        for (auto* flags : {&edges, &no_between}) flags->resize(padded);
      }
    }
  }
  LatitudeTable latitudes;
  int rows_per_distance;
  PolarColumns polar;
  std::unique_ptr<PrecisePositions> precise;  // null unless positions are computed in double
  std::vector<float> omega, exact_omega, zero_omega;
  PositionArrays samples[2];  // of the two stations around A
  std::array<std::vector<PositionArrays>, kMaxSources> pair_samples;  // the same, of each source
  SampleReader reader;
  std::vector<RowPiece> pieces;
  std::vector<std::uint8_t> levels;  // stored rows before they are blended
  std::vector<std::int16_t> sum, row_weight;
  std::vector<RowRun> unresolved;  // hidden rows that no station sees
  std::unique_ptr<RowMapping> mapping;
  std::vector<float> depth_omega;
  std::unique_ptr<LatitudeTable> depth_latitudes;
  std::vector<float> shift_u, shift_v;
  std::vector<std::int32_t> edges, no_between;  // [depth row]: -1 or 0, as ShiftedRows has them
  std::vector<std::vector<std::int16_t>> source_weights;  // [source][depth row]
  std::array<std::vector<std::uint8_t>, 4> usable;        // [source][depth row], of masked lines
  std::vector<std::uint8_t> most, seeing;  // [depth row], as ColumnKernels::weigh_rows has them
  std::vector<float> weight_scale;
  std::vector<std::uint8_t> hidden;  // [depth row]: what no source sees of it, 0 to kSeen
  std::vector<std::uint8_t> fill;    // rgb of a run of hidden rows
  bool any_hidden = false;
  double skip_px = 0.0;    // of the current column (work_skipped.h)
  bool any_shared = true;  // whether any row is blended from several sources
  std::array<std::vector<std::uint8_t>, 4> unskipped;  // [source][depth row], of the visible rows
  std::vector<std::uint8_t> dropped;                   // [depth row]
  std::vector<std::uint8_t> needed;                    // [depth row], of one source
  std::vector<std::uint8_t> near;                      // [depth row] or [row]
  std::vector<Reading> readings;                       // the same
  std::unique_ptr<RingVisibility> ring;
  std::unique_ptr<StationVisibility> stations;
  std::vector<std::uint8_t> seen_by_line;  // [depth row], of one source
  DepthColumn depth;
};

}  // namespace raywalk
