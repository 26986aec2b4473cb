#include "core/view/station_mixing.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"
#include "core/room/tiled_rays.h"
#include "core/view/column_rows.h"
#include "core/view/mask_check.h"
#include "core/view/mixing_scratch.h"

namespace raywalk {
namespace {

const Eigen::Vector3d& station_m(const Room& room, int line, int station) {
  return room.grid()
      .lines[static_cast<std::size_t>(line)]
      .stations[static_cast<std::size_t>(station)]
      .position_m;
}

// Asks for the tiles of a compressed line that samples read.
void require_samples(const LineVolume& volume, int station, const SamplePlaces& at, int rows,
                     bool cubic) {
  if (!volume.form().compressed()) return;
  const PanoramaSize size = volume.panorama();
  const std::size_t column_bytes = 3 * static_cast<std::size_t>(size.height);
  std::array<TileLayout::Bytes, 4> known{};  // of the columns around, one after the other
  const auto require = [&](int theta, TileLayout::Bytes* tile) {
    const std::size_t begin = column_bytes * static_cast<std::size_t>(theta);
    if (begin >= tile->begin && begin < tile->end) return;
    volume.require(station, begin, begin + column_bytes);
    *tile = volume.decoded_with(begin);
  };
  for (int i = 0; i < rows; ++i) {
    const int left = at.left[i] / static_cast<int>(column_bytes);
    const int right = at.right[i] / static_cast<int>(column_bytes);
    require(left, &known[0]);
    require(right, &known[1]);
    if (!cubic) continue;
    require(wrapped_column(left - 1, size.width), &known[2]);
    require(wrapped_column(right + 1, size.width), &known[3]);
  }
}

}  // namespace

StationMixing::StationMixing(const MixedView& view)
    : view_(view), scratch_(std::make_unique<Scratch>(view.distances.size().height)) {}

StationMixing::~StationMixing() = default;

void StationMixing::render(int first, int count, RowRun rows, cv::Mat image) {
  const TileReading reading;
  Scratch& s = *scratch_;
  for (int i = 0; i < count; ++i) {
    Column& column = s.columns[static_cast<std::size_t>(i)];
    prepare_column(view_, (first + i) % view_.output.width, &column);
    if (view_.is_initial()) continue;
    column.edges = view_.edges.column(column.nearest);
    for (std::size_t k = 0; k < column.sources.count; ++k) {
      const ColumnSource& of = column.sources.source[k];
      const std::uint8_t* const occluded =
          view_.visibility.occluded(column.nearest, of.at.line, of.behind());
      column.occluded[k] = occluded == nullptr ? s.nothing_occluded.data() : occluded;
    }
  }
  for (RowRun tile{rows.begin, 0}; tile.begin < rows.end; tile.begin = tile.end) {
    // Tiles begin with a row of the distances, if a whole number of rows lies in each.
    tile.end = std::min((tile.begin / kRows + 1) * kRows, rows.end);
    render_tile(count, tile);
    store_tile({s.tile.data(), kStride, 3 * static_cast<std::size_t>(count), tile.end - tile.begin},
               image.ptr(tile.begin - rows.begin), image.step);
  }
  counts_.all += static_cast<std::int64_t>(count) * (rows.end - rows.begin);
}

void StationMixing::render_tile(int count, RowRun rows) {
  Scratch& s = *scratch_;
  const bool stored = view_.is_initial() && shows_stored_columns();
  // A column is placed before the one in front of it is mixed, so that its pixels arrive in time.
  if (!stored) place_rows(s.columns[0], rows, &s.placed[0]);
  const auto columns = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < columns; ++i) {
    const Column& column = s.columns[i];
    std::uint8_t* const bgr = s.tile.data() + 3 * i;
    Placed& placed = s.placed[i % 2];
    if (stored && !column.reads.empty()) {
      mix_stored(column, rows, bgr);
      continue;
    }
    Placed* next = nullptr;
    if (!stored && i + 1 < columns) {
      next = &s.placed[(i + 1) % 2];
      place_rows(s.columns[i + 1], rows, next);
    }
    if (!stored) mix(column.any_masks, rows.end - rows.begin, &placed, next, bgr, kStride);
    fill_rows(column, rows, placed.total.data(), bgr);
    render_edges(column, rows, bgr);
  }
}

void StationMixing::place_rows(const Column& column, RowRun rows, Placed* placed) {
  if (view_.is_initial()) return place_cut(column, rows, placed);
  Scratch& s = *scratch_;
  placed->count = 0;
  const auto begin = static_cast<std::size_t>(rows.begin);
  const int per_row = view_.rows.per_row();
  const bool whole = per_row != 0 && rows.begin % per_row == 0 && rows.end % per_row == 0;
  const RowsBetween between{view_.rows.nearest.data() + begin, view_.rows.down.data() + begin,
                            whole ? per_row : 0, rows.end - rows.begin};
  find_distances(column, between);
  if (column.reads.size() == 1) {
    // It is read everywhere, and what it does not see is filled afterwards.
    s.row_weight.fill(1.0f);
    place_between(column, between, column.reads[0], placed);
    return;
  }
  const int first = between.first(), count = between.last() + 1 - first;
  std::array<const std::uint8_t*, kMaxSources> occluded{};
  for (std::size_t i = 0; i < column.sources.count; ++i) occluded[i] = column.occluded[i] + first;
  find_weights(column, occluded, column.trust == nullptr ? nullptr : column.trust + first, count);
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    if (!normalise(s.weight[k].data(), s.total.data(), count, s.part.data() + first)) continue;
    repeat_rows(s.part.data(), between, s.row_weight.data());
    place_between(column, between, column.reads[k], placed);
  }
}

void StationMixing::find_distances(const Column& column, const RowsBetween& rows) {
  Scratch& s = *scratch_;
  const int height = view_.distances.size().height;
  const int above = std::max(rows.first() - 1, 0), below = std::min(rows.last() + 1, height - 1);
  const float tolerance = view_.distances.surface_tolerance();
  interpolate_columns(view_.distances.column(column.nearest) + above,
                      view_.distances.column(column.other) + above, below - above + 1,
                      std::fabs(column.right), tolerance, s.inverse.data() + above);
  float* const joined = s.joined.data() + 1;  // of row 0
  find_joined(s.inverse.data(), above, below, tolerance, joined);
  joined[-1] = height > 1 ? joined[0] : 0.0f;
  joined[height - 1] = height > 1 ? joined[height - 2] : 0.0f;
}

void StationMixing::place_between(const Column& column, const RowsBetween& rows, const Read& read,
                                  Placed* placed) {
  Scratch& s = *scratch_;
  const PanoramaSize captured = view_.room.panorama();
  const int height = view_.distances.size().height;
  const int above = std::max(rows.first() - 1, 0), below = std::min(rows.last() + 1, height - 1);
  const Latitudes& latitudes = view_.distances.latitudes();
  float *const u = s.u.data() + 1, *const v = s.v.data() + 1;  // of row 0
  find_positions(latitudes.sin_phi.data() + above, latitudes.cos_phi.data() + above,
                 s.inverse.data() + above, below - above + 1,
                 offset_in_column(column.eye_m - station_m(view_.room, read.line, read.station),
                                  column.theta_rad),
                 captured, u + above, v + above);
  // Beyond the middles of the first and the last row they go on as between them and the next ones.
  for (float* const of : {u, v}) {
    if (above == 0) of[-1] = height > 1 ? 2.0f * of[0] - of[1] : of[0];
    if (below == height - 1) {
      of[height] = height > 1 ? 2.0f * of[height - 1] - of[height - 2] : of[0];
    }
  }
  PlacedStation& station = placed->add(read);
  const float wild = static_cast<float>(captured.width) / 8.0f;  // columns jump behind a station
  interpolate_rows(u, s.joined.data() + 1, rows, wild, station.u.data());
  interpolate_rows(v, s.joined.data() + 1, rows, wild, station.v.data());
  finish(column.captured, s.row_weight.data(), rows.rows, &station);
}

void StationMixing::find_weights(const Column& column,
                                 const std::array<const std::uint8_t*, kMaxSources>& occluded,
                                 const float* trust, int count) {
  Scratch& s = *scratch_;
  std::fill_n(s.total.begin(), count, 0.0f);
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    const Read& read = column.reads[k];
    add_share(occluded[read.source], read.by, trust, read.share, count, s.weight[k].data(),
              s.total.data());
  }
}

void StationMixing::place_points(const Points& points, const float* weight, const Read& read,
                                 Placed* placed) {
  PlacedStation& station = placed->add(read);
  const PanoramaSize captured = view_.room.panorama();
  const Eigen::Vector3d to_eye_m = points.eye_m - station_m(view_.room, read.line, read.station);
  find_positions(points.sin_phi, points.cos_phi, points.inverse, points.count,
                 offset_in_column(to_eye_m, points.theta_rad), captured, station.u.data(),
                 station.v.data());
  finish(points.captured, weight, points.count, &station);
}

void StationMixing::finish(float column, const float* weight, int count, PlacedStation* station) {
  const PanoramaSize captured = view_.room.panorama();
  place_samples(station->u.data(), station->v.data(), count, column, captured, station->u.data(),
                station->places());
  std::copy_n(weight, count, station->weight.begin());
  weigh_samples(station->v.data(), weight, count, captured, station->down.data());
}

void StationMixing::mix(bool any_masks, int rows, Placed* placed, Placed* next, std::uint8_t* bgr,
                        int stride) {
  Scratch& s = *scratch_;
  const PanoramaSize captured = view_.room.panorama();
  const bool cubic = view_.options.interpolation == Interpolation::kCubic;
  if (any_masks) remove_masked(rows, placed);
  bool any_exposure = false;
  for (std::size_t k = 0; k < placed->count; ++k) {
    PlacedStation& station = placed->stations[k];
    const Read& read = station.read;
    const LineVolume& volume = view_.room.volume(read.line);
    s.samples[k] = {.pixels = volume.rays(read.station),
                    .at = station.places(),
                    .u = station.u.data(),
                    .v = station.v.data(),
                    .weight = station.weight.data()};
    require_samples(volume, read.station, s.samples[k].at, rows, cubic);
    if (view_.exposure != nullptr && !view_.exposure->is_one(read.line, read.station)) {
      // Rows of a column follow each other; other samples have nothing to do with each other.
      const int step = stride == kStride ? kExposureStep : 1;
      for (int node = 0; node <= rows / step + 1; ++node) {
        const auto row = static_cast<std::size_t>(std::min(node * step, rows - 1));
        const cv::Vec4f factors =
            view_.exposure->at(read.line, read.station, station.u[row], station.v[row]);
        std::copy_n(factors.val, 4,
                    station.exposure.begin() + static_cast<std::ptrdiff_t>(4 * node));
      }
      s.samples[k].exposure = station.exposure.data();
      s.samples[k].exposure_step = step;
      any_exposure = true;
    }
  }
  const std::span samples(s.samples.data(), placed->count);
  if (cubic || any_exposure) {
    mix_exact(samples, cubic, captured, rows, bgr, stride);
  } else {
    std::size_t ahead = 0;
    for (std::size_t k = 0; next != nullptr && k < next->count; ++k) {
      PlacedStation& station = next->stations[k];
      s.ahead[ahead++] = {view_.room.volume(station.read.line).rays(station.read.station),
                          station.left.data(), station.right.data()};
    }
    mix_linear(samples, std::span(s.ahead.data(), ahead), rows, bgr, stride);
  }
}

void StationMixing::remove_masked(int rows, Placed* placed) {
  const int beyond = view_.options.interpolation == Interpolation::kCubic ? 1 : 0;
  const PanoramaSize captured = view_.room.panorama();
  const std::span used(placed->stations.data(), placed->count);
  std::fill_n(placed->total.begin(), rows, 0.0f);
  for (PlacedStation& station : used) {
    MaskCheck check(view_.room, station.read.line, station.read.station, beyond);
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows); ++i) {
      if (station.weight[i] > 0.0f && station.read.has_masks &&
          !(view_.is_initial() ? check.valid(station.left[i], station.right[i])
                               : check.usable(station.left[i], station.right[i]))) {
        station.weight[i] = 0.0f;
      }
      placed->total[i] += station.weight[i];
    }
  }
  for (PlacedStation& station : used) {
    normalise(station.weight.data(), placed->total.data(), rows, station.weight.data());
    weigh_samples(station.v.data(), station.weight.data(), rows, captured, station.down.data());
  }
}

}  // namespace raywalk
