#include "core/view/station_mixing.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/geometry/panorama_pixels.h"
#include "core/room/tile_cache.h"
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
  s.positions_used = 0;
  for (int i = 0; i < count; ++i) {
    prepare((first + i) % view_.output.width, &s.columns[static_cast<std::size_t>(i)]);
  }
  for (RowRun tile{rows.begin, 0}; tile.begin < rows.end; tile.begin = tile.end) {
    tile.end = std::min(tile.begin + kRows, rows.end);
    for (int i = 0; i < count; ++i) {
      const Column& column = s.columns[static_cast<std::size_t>(i)];
      render_rows(column, tile, s.tile.data() + 3 * i);
      render_edges(column, tile, s.tile.data() + 3 * i);
    }
    for (int row = tile.begin; row < tile.end; ++row) {
      std::memcpy(image.ptr(row - rows.begin), s.tile.data() + (row - tile.begin) * kStride,
                  3 * static_cast<std::size_t>(count));
    }
  }
  counts_.all += static_cast<std::int64_t>(count) * (rows.end - rows.begin);
}

void StationMixing::prepare(int u, Column* column) {
  Column& c = *column;
  const int width = view_.distances.size().width;
  const int captured = view_.room.panorama().width;
  c.u = u;
  c.theta_rad = theta_of_column(u, view_.output.width);
  c.eye_m = view_.distances.eye().position_m(c.theta_rad);
  c.captured = static_cast<float>((u + 0.5) * captured / view_.output.width - 0.5 + captured);
  const double at = (u + 0.5) * width / view_.output.width - 0.5;
  c.left = wrapped_column(static_cast<int>(std::floor(at)), width);
  c.part = static_cast<float>(at - std::floor(at));
  constexpr float kNone = 1e-4f;
  c.right = c.part > kNone ? (c.left + 1) % width : c.left;
  c.nearest = c.part < 0.5f ? c.left : c.right;
  c.trust = view_.distances.trust(c.nearest);
  c.edges = view_.edges.column(c.nearest);
  c.sources = view_.sources(c.theta_rad);
  c.reads.clear();
  c.any_masks = false;
  for (std::size_t i = 0; i < c.sources.count; ++i) add_reads(i, column);
  if (scratch_->stations.size() < std::max(c.reads.size(), std::size_t{1})) {
    scratch_->stations.resize(std::max(c.reads.size(), std::size_t{1}));
  }
}

void StationMixing::add_reads(std::size_t source, Column* column) const {
  const ColumnSource& of = column->sources.source[source];
  const int line = of.at.line;
  const std::uint8_t* const occluded =
      view_.visibility.occluded(column->nearest, line, of.behind());
  column->occluded[source] = occluded == nullptr ? scratch_->nothing_occluded.data() : occluded;
  const int mixed = view_.options.stations_mixed;
  // Where distances are unreliable a single station would show things out of place: the two
  // neighbours are mixed by nearness.
  const int most = column->trust == nullptr ? mixed : std::max(mixed, 2);
  const StationWindow window = stations_mixed(of.at, view_.room.volume(line).stations(), most);
  const std::size_t first = column->reads.size();
  StationShare sum{0.0f, 0.0f};
  for (int station = window.first; station <= window.last; ++station) {
    const auto from_met = static_cast<float>(station - of.at.station - of.at.fraction);
    const StationShare share{
        station_share(from_met, mixed),
        mixed > 2 ? station_share(from_met, mixed) : std::max(1.0f - std::fabs(from_met), 0.0f)};
    constexpr float kNone = 1e-3f;
    if (share.reliable < kNone && (column->trust == nullptr || share.unreliable < kNone)) continue;
    sum.reliable += share.reliable;
    sum.unreliable += share.unreliable;
    column->reads.push_back(
        {.source = source,
         .line = line,
         .station = station,
         .share = share,
         .by = view_.visibility.occluders(column->nearest, line, of.behind(), station),
         .has_masks = has_masks(view_.room, line, station)});
    column->any_masks |= column->reads.back().has_masks;
  }
  for (Read& read : std::span(column->reads).subspan(first)) {
    read.share.reliable *= of.share / sum.reliable;
    read.share.unreliable *= of.share / std::max(sum.unreliable, 1e-6f);
  }
}

const StationMixing::Positions& StationMixing::positions_of(int line, int station, int theta) {
  Scratch& s = *scratch_;
  for (std::size_t i = s.positions_used; i-- > 0;) {
    const Positions& known = s.positions[i];
    if (known.line == line && known.station == station && known.theta == theta) return known;
  }
  if (s.positions_used == s.positions.size()) s.positions.emplace_back();
  Positions& found = s.positions[s.positions_used++];
  const Latitudes& latitudes = view_.distances.latitudes();
  found.line = line;
  found.station = station;
  found.theta = theta;
  // One more, the same again: maps of a single row have no other to interpolate to.
  found.from_column.resize(latitudes.sin_phi.size() + 1);
  found.v.resize(found.from_column.size());
  const double theta_rad = theta_of_column(theta, view_.distances.size().width);
  const Eigen::Vector3d to_eye_m =
      view_.distances.eye().position_m(theta_rad) - station_m(view_.room, line, station);
  find_positions(latitudes.sin_phi.data(), latitudes.cos_phi.data(), view_.distances.column(theta),
                 latitudes.rows(), offset_in_column(to_eye_m, theta_rad), view_.room.panorama(),
                 found.from_column.data(), found.v.data());
  found.from_column.back() = found.from_column[latitudes.sin_phi.size() - 1];
  found.v.back() = found.v[latitudes.sin_phi.size() - 1];
  return found;
}

void StationMixing::render_rows(const Column& column, RowRun rows, std::uint8_t* bgr) {
  Scratch& s = *scratch_;
  // The rows of the distances around.
  const RowRun around{view_.rows.upper[static_cast<std::size_t>(rows.begin)],
                      std::min(view_.rows.upper[static_cast<std::size_t>(rows.end - 1)] + 2,
                               view_.distances.size().height)};
  const int count = around.end - around.begin;
  // A single station is read everywhere, and what it does not see is filled afterwards.
  const bool single = column.reads.size() == 1 && !column.any_masks;
  if (single) {
    s.stations[0].part.fill(kWeightOne);
  } else {
    find_weights(column, around);
  }
  const float tolerance = view_.distances.surface_tolerance();
  const float* inverse = view_.distances.column(column.left) + around.begin;
  if (column.left != column.right) {
    find_parts(inverse, view_.distances.column(column.right) + around.begin, count, column.part,
               tolerance, s.parts.data(), s.inverse.data());
    inverse = s.inverse.data();
  }
  find_steps(inverse, count, tolerance, s.step.data());
  s.count = 0;
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    if (!single && !find_parts_of_rows(k, rows, around)) continue;
    place_rows(column, column.reads[k], s.count, rows, around);
    s.read[s.count++] = &column.reads[k];
  }
  mix(column.any_masks, s.count, rows.end - rows.begin, bgr, kStride);
  fill_rows(column, rows, bgr);
}

void StationMixing::find_weights(const Column& column, RowRun around) {
  Scratch& s = *scratch_;
  const int count = around.end - around.begin;
  std::fill_n(s.total.begin(), count, 0.0f);
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    const Read& read = column.reads[k];
    add_share(column.occluded[read.source] + around.begin, read.by,
              column.trust == nullptr ? nullptr : column.trust + around.begin, read.share, count,
              s.weight[k].data(), s.total.data());
  }
}

bool StationMixing::find_parts_of_rows(std::size_t k, RowRun rows, RowRun around) {
  Scratch& s = *scratch_;
  const std::span part(s.part.data(), static_cast<std::size_t>(around.end - around.begin));
  normalise(s.weight[k].data(), s.total.data(), static_cast<int>(part.size()), part.data());
  if (std::ranges::all_of(part, [](std::int16_t weight) { return weight == 0; })) return false;
  std::int16_t* const of_rows = s.stations[s.count].part.data();
  const int* const nearest = view_.rows.nearest.data() + rows.begin;
  for (int i = 0; i < rows.end - rows.begin; ++i) {
    of_rows[i] = part[static_cast<std::size_t>(nearest[i] - around.begin)];
  }
  return true;
}

void StationMixing::place_rows(const Column& column, const Read& read, std::size_t k, RowRun rows,
                               RowRun around) {
  Scratch& s = *scratch_;
  const PanoramaSize captured = view_.room.panorama();
  const auto width = static_cast<float>(captured.width);
  const Positions* const left = &positions_of(read.line, read.station, column.left);
  const float* from_column = left->from_column.data() + around.begin;
  const float* v = left->v.data() + around.begin;
  if (column.left != column.right) {
    const Positions& right = positions_of(read.line, read.station, column.right);
    const int count = around.end - around.begin + 1;
    constexpr float kNever = 1e9f;
    between_columns(from_column, right.from_column.data() + around.begin, s.parts.data(), count,
                    width, s.from_column.data());
    between_columns(v, right.v.data() + around.begin, s.parts.data(), count, kNever, s.v.data());
    from_column = s.from_column.data();
    v = s.v.data();
  }
  Scratch::Station& station = s.stations[k];
  const RowsBetween between{view_.rows.upper.data() + rows.begin,
                            view_.rows.part.data() + rows.begin, around.begin, view_.rows.per_row(),
                            rows.end - rows.begin};
  const float wild = width / 8.0f;
  between_rows(from_column, s.step.data(), between, wild, station.u.data());
  between_rows(v, s.step.data(), between, wild, station.v.data());
  place_samples(station.u.data(), station.v.data(), between.rows, column.captured, captured,
                station.u.data(), station.places());
}

void StationMixing::place_points(const Points& points, const Read& read, std::size_t k) {
  Scratch::Station& station = scratch_->stations[k];
  const PanoramaSize captured = view_.room.panorama();
  const Eigen::Vector3d to_eye_m = points.eye_m - station_m(view_.room, read.line, read.station);
  find_positions(points.sin_phi, points.cos_phi, points.inverse, points.count,
                 offset_in_column(to_eye_m, points.theta_rad), captured, station.u.data(),
                 station.v.data());
  if (points.right_px != nullptr) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
      station.u[i] += points.right_px[i];
    }
  }
  place_samples(station.u.data(), station.v.data(), points.count, points.captured, captured,
                station.u.data(), station.places());
}

void StationMixing::mix(bool any_masks, std::size_t count, int rows, std::uint8_t* bgr,
                        int stride) {
  Scratch& s = *scratch_;
  const PanoramaSize captured = view_.room.panorama();
  const bool cubic = view_.options.interpolation == Interpolation::kCubic;
  if (any_masks) remove_masked(count, rows);
  bool any_exposure = false;
  for (std::size_t k = 0; k < count; ++k) {
    const Read& read = *s.read[k];
    Scratch::Station& station = s.stations[k];
    const LineVolume& volume = view_.room.volume(read.line);
    s.samples[k] = {.pixels = volume.rays(read.station),
                    .at = station.places(),
                    .u = station.u.data(),
                    .v = station.v.data(),
                    .weight = station.part.data()};
    require_samples(volume, read.station, s.samples[k].at, rows, cubic);
    if (view_.exposure != nullptr && !view_.exposure->is_one(read.line, read.station)) {
      // Rows of a column follow each other; other samples have nothing to do with each other.
      look_up_exposure(read, k, rows, stride == kStride ? kExposureStep : 1);
      any_exposure = true;
    }
    if (stride == kStride) prefetch_samples(s.samples[k], rows, 3 * captured.height);
  }
  const std::span samples(s.samples.data(), count);
  if (cubic || any_exposure) {
    mix_exact(samples, cubic, captured, rows, bgr, stride);
  } else {
    mix_linear(samples, rows, bgr, stride);
  }
}

void StationMixing::look_up_exposure(const Read& read, std::size_t k, int rows, int step) {
  Scratch::Station& station = scratch_->stations[k];
  for (int node = 0; node <= rows / step + 1; ++node) {
    const auto row = static_cast<std::size_t>(std::min(node * step, rows - 1));
    const cv::Vec4f factors =
        view_.exposure->at(read.line, read.station, station.u[row], station.v[row]);
    std::copy_n(factors.val, 4, station.exposure.begin() + 4 * node);
  }
  scratch_->samples[k].exposure = station.exposure.data();
  scratch_->samples[k].exposure_step = step;
}

void StationMixing::remove_masked(std::size_t count, int rows) {
  Scratch& s = *scratch_;
  const int beyond = view_.options.interpolation == Interpolation::kCubic ? 1 : 0;
  std::fill_n(s.total.begin(), rows, 0.0f);
  for (std::size_t k = 0; k < count; ++k) {
    const Read& read = *s.read[k];
    Scratch::Station& station = s.stations[k];
    MaskCheck check(view_.room, read.line, read.station, beyond);
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows); ++i) {
      const bool usable = station.part[i] != 0 &&
                          (!read.has_masks || check.usable(station.left[i], station.right[i]));
      station.weight[i] = usable ? station.part[i] : 0.0f;
      s.total[i] += station.weight[i];
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    normalise(s.stations[k].weight.data(), s.total.data(), rows, s.stations[k].part.data());
  }
}

}  // namespace raywalk
