#include "core/view/column_renderer.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/view/column_scratch.h"
#include "core/view/sample_check.h"

namespace raywalk {

int rows_per_distance(const ViewInputs& view) {
  if (view.distances == nullptr || view.layers || view.arithmetic == Arithmetic::kDouble) return 1;
  const int distance_rows = view.distances->size().height;
  const int ratio = view.output.height / distance_rows;
  const bool whole = ratio * distance_rows == view.output.height;
  return whole && (ratio == 2 || ratio == 4 || ratio == 8) ? ratio : 1;
}

PolarColumns polar_columns_of(const ViewInputs& view) {
  // Cubic samples are read from neighbouring columns.
  if (rows_per_distance(view) == 1 || view.interpolation == Interpolation::kCubic) return {};
  return polar_columns(view.room.panorama());
}

RowRun rows_between_polar_caps(int height, int step) {
  const int cap = step == 2 ? height / 6 : height * 2 / 25;  // cos 60 deg = 1/2, cos 75.6 deg < 1/4
  return {cap, height - cap};
}

ColumnRenderer::ColumnRenderer(const ViewInputs& view)
    : view_(view),
      kernels_(column_kernels()),
      scratch_(std::make_unique<Scratch>(
          view, view.distances != nullptr ? view.distances->size().height : 0)) {}

ColumnRenderer::~ColumnRenderer() = default;

PixelCounts ColumnRenderer::counts() const {
  PixelCounts counts = counts_;
  counts.work.found = scratch_->reader.found();
  counts.work.samples = counts.work.found + scratch_->reader.stored();
  return counts;
}

void ColumnRenderer::render(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  counts_.all += view_.output.height;
  scratch_->unresolved.clear();
  if (sources.empty()) {
    render_unserved(u, rgb);
  } else if (view_.distances == nullptr) {
    render_initial(u, sources, rgb);
  } else {
    render_corrected(u, sources, view_.rows, rgb);
  }
}

bool ColumnRenderer::render_sparsely(int u, std::span<const RaySource> sources, int step,
                                     std::uint8_t* rgb) {
  if (sources.empty() || scratch_->rows_per_distance == 1) {
    render(u, sources, rgb);
    return false;
  }
  counts_.all += view_.output.height;
  scratch_->unresolved.clear();
  render_corrected(
      u, sources, common_rows(rows_between_polar_caps(view_.output.height, step), view_.rows), rgb);
  return true;
}

std::span<const RowRun> ColumnRenderer::unknown_rows() const { return scratch_->unresolved; }

void ColumnRenderer::fill_empty(int u, std::uint8_t* rgb) {
  counts_.empty += view_.output.height;
  scratch_->unresolved.assign(1, {0, view_.output.height});
  const int stripe = std::max(1, view_.output.height / 32);
  for (int row = 0; row < view_.output.height; ++row) {
    const bool dark = ((u + row) / stripe) % 2 == 0;
    std::fill_n(rgb + 3 * row, 3, static_cast<std::uint8_t>(dark ? 72 : 88));
  }
}

void ColumnRenderer::render_unserved(int u, std::uint8_t* rgb) {
  fill_empty(u, rgb);
  if (view_.distances == nullptr) return;
  const std::int64_t filled = counts_.filled;
  scratch_->unresolved.clear();
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  const int depth_theta = depth_column(theta_rad);
  prepare_omega(u);
  begin_depth_column(depth_theta);
  std::ranges::fill(scratch_->hidden, kSeen);
  fill_hidden(theta_rad, depth_theta, rgb);
  counts_.filled = filled;  // counted as empty
}

int ColumnRenderer::depth_column(double theta_rad) const {
  const PanoramaSize size = view_.distances->size();
  return split_column(std::round(pixel_from_angles({theta_rad, 0.0}, size).u), size.width).whole;
}

void ColumnRenderer::render_corrected(int u, std::span<const RaySource> sources, RowRun rows,
                                      std::uint8_t* rgb) {
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  const int depth_theta = depth_column(theta_rad);
  prepare_omega(u);
  weigh_sources(theta_rad, depth_theta, sources);
  if (sources.size() == 1) {
    mix_source(u, theta_rad, sources[0], rows, rgb);
  } else {
    blend_sources(u, theta_rad, sources, rows, rgb);
  }
  if (scratch_->any_hidden) {
    fill_hidden(theta_rad, depth_theta, rgb);
    stretch_unresolved(u, sources, rows, rgb);
  }
}

void ColumnRenderer::mix_source(int u, double theta_rad, const RaySource& source, RowRun rows,
                                std::uint8_t* rgb) {
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  snap_to_layers(source);
  for (const RowPiece& piece : split_rows(u, theta_rad, source, rows)) {
    mix_piece(u, theta_rad, source, piece, rgb);
  }
  if (view_.layers) std::swap(scratch_->omega, scratch_->exact_omega);
}

void ColumnRenderer::blend_sources(int u, double theta_rad, std::span<const RaySource> sources,
                                   RowRun rows, std::uint8_t* rgb) {
  if (mixes_in_registers(sources)) {
    mix_weighted(theta_rad, sources, rows, rgb);
    return;
  }
  if (scratch_->any_shared) std::fill(scratch_->sum.begin(), scratch_->sum.end(), std::int16_t{0});
  for (size_t i = 0; i < sources.size(); ++i) {
    const auto& weights = scratch_->source_weights[i];
    for (size_t row = 0; row < scratch_->needed.size(); ++row) {
      scratch_->needed[row] = weights[row] > 0;
    }
    if (scratch_->any_shared) {
      add_source(u, theta_rad, sources[i], weights, rows);
    } else {
      mix_source(u, theta_rad, sources[i], rows, rgb);
    }
  }
  if (scratch_->any_shared) {
    kernels_.finish(scratch_->sum.data() + 4 * rows.begin, rows.end - rows.begin,
                    rgb + 3 * rows.begin);
  }
}

bool ColumnRenderer::mixes_in_registers(std::span<const RaySource> sources) const {
  return !skips_rows() && scratch_->rows_per_distance > 1 &&
         view_.interpolation == Interpolation::kLinear && !scratch_->reader.counts_bytes() &&
         std::ranges::all_of(sources, [&](const RaySource& source) {
           return usual_reading(source) == Reading::kBoth &&
                  !scratch_->reader.gains().change(source.line, source.station) &&
                  !scratch_->reader.gains().change(source.line, source.station + 1);
         });
}

void ColumnRenderer::mix_weighted(double theta_rad, std::span<const RaySource> sources, RowRun rows,
                                  std::uint8_t* rgb) {
  std::array<WeightedPair, kMaxSources> pairs;
  for (size_t i = 0; i < sources.size(); ++i) {
    const RaySource& source = sources[i];
    auto& positions = scratch_->pair_samples[i];
    if (positions.empty()) positions.assign(2, PositionArrays(view_.output.height));
    const auto samples = [&](int next) {
      return find_run(theta_rad, source.line, source.station + next, rows,
                      positions[static_cast<size_t>(next)].positions());
    };
    pairs[i] = {samples(0), samples(1), fixed_weight(source.fraction),
                scratch_->source_weights[i].data()};
    const std::int64_t read = rows_with_weight(scratch_->source_weights[i], rows);
    count_readings(Reading::kBoth, read);
    scratch_->reader.count_found(2 * read);
  }
  std::uint8_t* const out = rgb + 3 * rows.begin;
  std::uint8_t* const end_of_rows = rgb + 3 * rows.end;
  const std::uint8_t beyond = *end_of_rows;
  kernels_.mix_weighted(pairs.data(), static_cast<int>(sources.size()), rows.begin, rows.end,
                        scratch_->rows_per_distance, out);
  *end_of_rows = beyond;
}

std::int64_t ColumnRenderer::rows_with_weight(std::span<const std::int16_t> weights,
                                              RowRun rows) const {
  const int per_row = scratch_->rows_per_distance;
  std::int64_t count = 0;
  for (int row = rows.begin / per_row; row * per_row < rows.end; ++row) {
    const RowRun covered = common_rows({row * per_row, (row + 1) * per_row}, rows);
    if (weights[static_cast<size_t>(row)] != 0) count += covered.end - covered.begin;
  }
  return count;
}

void ColumnRenderer::prepare_omega(int u) {
  const DistanceView& distances = *view_.distances;
  const PanoramaSize size = distances.size();
  const double map_u = (u + 0.5) * size.width / view_.output.width - 0.5;
  const ColumnPosition position = split_column(map_u, size.width);
  kernels_.mix_omega(distances.column(position.whole),
                     distances.column((position.whole + 1) % size.width), position.part,
                     size.height, distances.surface_tolerance(), scratch_->depth_omega.data());
  if (scratch_->rows_per_distance > 1) {
    kernels_.find_edges(scratch_->depth_omega.data(), size.height - 1,
                        distances.surface_tolerance(), scratch_->edges.data());
    return;
  }
  kernels_.upsample_omega(scratch_->depth_omega.data(), scratch_->mapping->upper.data(),
                          scratch_->mapping->fraction.data(), view_.output.height,
                          distances.surface_tolerance(), scratch_->omega.data());
}

void ColumnRenderer::begin_depth_column(int depth_theta) {
  DepthColumn& depth = scratch_->depth;
  if (depth.theta == depth_theta) return;
  depth.theta = depth_theta;
  depth.visible.clear();
  depth.visible.reserve(8);  // four lines, in front and behind: returned spans stay valid
  depth.fill.assign(static_cast<size_t>(view_.distances->size().height), Scratch::kUnknown);
}

std::span<const std::uint8_t> ColumnRenderer::visible_rows(int depth_theta,
                                                           const RaySource& source) {
  begin_depth_column(depth_theta);
  DepthColumn& depth = scratch_->depth;
  const bool behind = source.d_p_m < 0.0;
  for (const auto& known : depth.visible) {
    if (known.line == source.line && known.behind == behind) return known.rows;
  }
  auto& visible = depth.visible.emplace_back();
  visible.line = source.line;
  visible.behind = behind;
  scratch_->ring->compute(*view_.distances, depth_theta, source.d_p_m, visible.rows);
  remove_hidden_from_stations(depth_theta, source, visible.rows);
  weigh_visibility(view_.distances->trust(depth_theta), visible.rows);
  return visible.rows;
}

void ColumnRenderer::remove_hidden_from_stations(int depth_theta, const RaySource& source,
                                                 std::vector<std::uint8_t>& visible) {
  auto& seen_by_line = scratch_->seen_by_line;
  seen_by_line = visible;
  const Reading reading = usual_reading(source);
  scratch_->stations->remove_hidden(
      {source.line, source.station, {reads(reading, 0), reads(reading, 1)}}, depth_theta, visible);
  for (size_t row = 0; row < visible.size(); ++row) {
    if (visible[row] == seen_by_line[row]) continue;
    // Where every station sees something nearer, so does the viewpoint, and its distance is wrong.
    if (fill_of(depth_theta, static_cast<int>(row)) == Scratch::kNone) visible[row] = 1;
  }
}

void ColumnRenderer::weigh_visibility(const float* trust, std::span<std::uint8_t> rows) {
  for (size_t row = 0; row < rows.size(); ++row) {
    const float doubt = trust == nullptr ? 0.0f : 1.0f - trust[row];
    rows[row] = rows[row] != 0 ? kSeen : static_cast<std::uint8_t>(std::lround(doubt * kSeen));
  }
}

std::span<const std::uint8_t> ColumnRenderer::usable_rows(double theta_rad, int depth_theta,
                                                          const RaySource& source, size_t which) {
  const auto visible = visible_rows(depth_theta, source);
  const LineVolume& volume = view_.room.volume(source.line);
  const LeftOutPixels& left_out = view_.room.distances(source.line).left_out();
  if (!volume.masked() && !left_out.any(source.station) && !left_out.any(source.station + 1)) {
    return visible;
  }
  // Visibility changes little within a column of the distances and is shared by its output columns;
  // masks must be exact to the pixel, so they are looked up at the actual sample positions.
  auto& usable = scratch_->usable[which];
  usable.assign(visible.begin(), visible.end());
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  snap_to_layers(source);
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(source), next)) continue;
    const RowRun all{0, view_.output.height};
    const SamplePositions at = find_run(theta_rad, source, next, all).positions;
    SampleCheck masks(volume, source.station + next);
    LeftOutCheck moved(left_out, source.station + next, volume.panorama());
    for (size_t row = 0; row < static_cast<size_t>(view_.output.height); ++row) {
      const std::int32_t left = at.offset_left[row];
      const std::int32_t right = at.offset_right[row];
      if (masks.valid(left, right) && moved.valid(left, right)) continue;
      usable[static_cast<size_t>(scratch_->mapping->nearest[row])] = 0;
    }
  }
  if (view_.layers) std::swap(scratch_->omega, scratch_->exact_omega);
  return usable;
}

double ColumnRenderer::blend_share(std::span<const RaySource> sources, size_t which) {
  double span_m = 0.0;
  for (const RaySource& source : sources) span_m += std::fabs(source.d_p_m);
  const double nearness =
      span_m > 0.0 ? 1.0 / (std::fabs(sources[which].d_p_m) / span_m + 1e-4) : 1.0;
  return sources[which].weight * nearness;
}

void ColumnRenderer::weigh_sources(double theta_rad, int depth_theta,
                                   std::span<const RaySource> sources) {
  const size_t rows = static_cast<size_t>(view_.distances->size().height);
  std::array<std::span<const std::uint8_t>, kMaxSources> visible;
  find_visible_rows(theta_rad, depth_theta, sources, visible);
  if (sources.size() == 1) {
    scratch_->needed.assign(visible[0].begin(), visible[0].end());
    find_hidden(visible[0]);
    return;
  }
  scratch_->source_weights.resize(std::max(scratch_->source_weights.size(), sources.size()));
  std::array<float, kMaxSources> shares{};
  std::array<const std::uint8_t*, kMaxSources> seen{};
  std::array<std::int16_t*, kMaxSources> weights{};
  for (size_t i = 0; i < sources.size(); ++i) {
    shares[i] = static_cast<float>(blend_share(sources, i));
    seen[i] = visible[i].data();
    scratch_->source_weights[i].resize(rows);
    weights[i] = scratch_->source_weights[i].data();
  }
  kernels_.weigh_rows(seen.data(), shares.data(), static_cast<int>(sources.size()),
                      static_cast<int>(rows), weights.data(), scratch_->most.data(),
                      scratch_->seeing.data(), scratch_->weight_scale.data());
  find_hidden(scratch_->most);
  scratch_->any_shared =
      !skips_rows() || std::ranges::any_of(scratch_->seeing, [](int lines) { return lines > 1; });
}

void ColumnRenderer::find_hidden(std::span<const std::uint8_t> seen) {
  std::uint8_t least = kSeen;
  for (size_t row = 0; row < seen.size(); ++row) {
    scratch_->hidden[row] = static_cast<std::uint8_t>(kSeen - seen[row]);
    least = std::min(least, seen[row]);
  }
  scratch_->any_hidden = least < kSeen;
}

void ColumnRenderer::snap_to_layers(const RaySource& source) {
  if (!view_.layers) return;
  kernels_.snap_to_layers(scratch_->latitudes.table(), view_.output.height,
                          static_cast<float>(source.d_p_m), *view_.layers, scratch_->omega.data());
}

void ColumnRenderer::add_source(int u, double theta_rad, const RaySource& source,
                                std::span<const std::int16_t> weights, RowRun rows) {
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  snap_to_layers(source);
  for (const RowPiece& piece : split_rows(u, theta_rad, source, rows)) {
    add_piece(u, theta_rad, source, piece, weights);
  }
  if (view_.layers) std::swap(scratch_->omega, scratch_->exact_omega);
}

StationSamples ColumnRenderer::samples_at(int line, int station, SamplePositions positions) const {
  const LineVolume& volume = view_.room.volume(line);
  const std::int32_t column_bytes = 3 * volume.panorama().height;
  return {volume.column(station, 0).data(),
          positions,
          {column_bytes, column_bytes * volume.panorama().width}};
}

StationSamples ColumnRenderer::find_samples(double theta_rad, int line, int station, int first_row,
                                            int rows, SamplePositions positions) {
  const float* omega = scratch_->omega.data() + first_row;
  if (scratch_->precise) {
    scratch_->precise->find(first_row, {omega, static_cast<size_t>(rows)},
                            displacement_from(line, station), theta_rad, view_.room.panorama(),
                            positions);
  } else {
    kernels_.find_samples(scratch_->latitudes.table(first_row), omega, rows,
                          offset_from(line, station, theta_rad), target_of(theta_rad), positions);
  }
  return samples_at(line, station, positions);
}

ColumnTarget ColumnRenderer::target_of(double theta_rad) const {
  const PanoramaSize captured = view_.room.panorama();
  const ColumnPosition position =
      split_column(pixel_from_angles({theta_rad, 0.0}, captured).u, captured.width);
  return {captured.width, captured.height, position.whole, position.part, scratch_->polar};
}

Eigen::Vector3d ColumnRenderer::displacement_from(int line, int station) const {
  const Line& geometry = view_.room.grid().lines[static_cast<size_t>(line)];
  return viewpoint_m() - geometry.stations[static_cast<size_t>(station)].position_m;
}

ColumnOffset ColumnRenderer::offset_from(int line, int station, double theta_rad) const {
  return column_offset(displacement_from(line, station), theta_rad);
}

Eigen::Vector3d ColumnRenderer::viewpoint_m() const {
  return {view_.plan.viewpoint().x_m, view_.plan.height_m(), view_.plan.viewpoint().z_m};
}

}  // namespace raywalk