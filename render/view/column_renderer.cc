#include "render/view/column_renderer.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/view/column_scratch.h"
#include "render/view/sample_check.h"

namespace raywalk {

RowRun rows_between_polar_caps(int height) { return {height / 6, height - height / 6}; }

ColumnRenderer::ColumnRenderer(const ViewInputs& view)
    : view_(view),
      kernels_(column_kernels()),
      scratch_(std::make_unique<Scratch>(
          view, view.distances != nullptr ? view.distances->size().height : 0)) {}

ColumnRenderer::~ColumnRenderer() = default;

void ColumnRenderer::render(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  counts_.all += view_.output.height;
  if (sources.empty()) {
    mark_empty(u, rgb);
  } else if (view_.distances == nullptr) {
    render_initial(u, sources, rgb);
  } else {
    render_corrected(u, sources, view_.rows, rgb);
  }
}

bool ColumnRenderer::render_sparsely(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  if (sources.size() != 1 || scratch_->rows_per_distance == 1) {
    render(u, sources, rgb);
    return false;
  }
  counts_.all += view_.output.height;
  render_corrected(u, sources,
                   common_rows(rows_between_polar_caps(view_.output.height), view_.rows), rgb);
  return true;
}

void ColumnRenderer::mark_empty(int u, std::uint8_t* rgb) {
  counts_.empty += view_.output.height;
  const int stripe = std::max(1, view_.output.height / 32);
  for (int row = 0; row < view_.output.height; ++row) {
    const bool dark = ((u + row) / stripe) % 2 == 0;
    std::fill_n(rgb + 3 * row, 3, static_cast<std::uint8_t>(dark ? 72 : 88));
  }
}

void ColumnRenderer::render_corrected(int u, std::span<const RaySource> sources, RowRun rows,
                                      std::uint8_t* rgb) {
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  const PanoramaSize depth_size = view_.distances->size();
  const int depth_theta =
      split_column(std::round(pixel_from_angles({theta_rad, 0.0}, depth_size).u), depth_size.width)
          .whole;
  prepare_omega(u);
  weigh_sources(theta_rad, depth_theta, sources);
  if (sources.size() == 1) {
    mix_source(theta_rad, sources[0], rows, rgb);
  } else {
    blend_sources(theta_rad, sources, rgb);
    rows = {0, view_.output.height};
  }
  if (scratch_->any_hidden) {
    fill_hidden(theta_rad, depth_theta, rgb);
    stretch_rest(u, sources, rows, rgb);
  }
}

void ColumnRenderer::mix_source(double theta_rad, const RaySource& source, RowRun rows,
                                std::uint8_t* rgb) {
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  snap_to_layers(source);
  const auto from_row = [&](StationSamples samples) {
    samples.positions.offset_left += rows.begin;
    samples.positions.offset_right += rows.begin;
    samples.positions.weight_right += rows.begin;
    samples.positions.weight_lower += rows.begin;
    return samples;
  };
  kernels_.mix_pair(from_row(find_samples(theta_rad, source, 0)),
                    from_row(find_samples(theta_rad, source, 1)), fixed_weight(source.fraction),
                    rows.end - rows.begin, rgb + 3 * rows.begin);
  if (view_.layers) std::swap(scratch_->omega, scratch_->exact_omega);
}

void ColumnRenderer::blend_sources(double theta_rad, std::span<const RaySource> sources,
                                   std::uint8_t* rgb) {
  std::fill(scratch_->sum.begin(), scratch_->sum.end(), std::int16_t{0});
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  for (size_t i = 0; i < sources.size(); ++i) {
    snap_to_layers(sources[i]);
    add_source(theta_rad, sources[i], scratch_->source_weights[i]);
    if (view_.layers) scratch_->omega = scratch_->exact_omega;
  }
  kernels_.finish(scratch_->sum.data(), view_.output.height, rgb);
}

void ColumnRenderer::prepare_omega(int u) {
  const DistanceView& distances = *view_.distances;
  const PanoramaSize size = distances.size();
  const double map_u = (u + 0.5) * size.width / view_.output.width - 0.5;
  const ColumnPosition position = split_column(map_u, size.width);
  kernels_.mix_omega(distances.column(position.whole),
                     distances.column((position.whole + 1) % size.width), position.part,
                     size.height, distances.surface_tolerance(), scratch_->depth_omega.data());
  kernels_.upsample_omega(scratch_->depth_omega.data(), scratch_->mapping->upper.data(),
                          scratch_->mapping->fraction.data(), view_.output.height,
                          distances.surface_tolerance(), scratch_->fraction.data(),
                          scratch_->omega.data());
}

std::span<const std::uint8_t> ColumnRenderer::visible_rows(int depth_theta,
                                                           const RaySource& source) {
  DepthColumn& depth = scratch_->depth;
  if (depth.theta != depth_theta) {
    depth.theta = depth_theta;
    depth.visible.clear();
    depth.visible.reserve(8);  // four lines, in front and behind: the spans handed out stay valid
    depth.fill.assign(static_cast<size_t>(view_.distances->size().height), Scratch::kUnknown);
  }
  const bool behind = source.d_p_m < 0.0;
  for (const auto& known : depth.visible) {
    if (known.line == source.line && known.behind == behind) return known.rows;
  }
  auto& visible = depth.visible.emplace_back();
  visible.line = source.line;
  visible.behind = behind;
  scratch_->ring->compute(*view_.distances, depth_theta, source.d_p_m, visible.rows);
  return visible.rows;
}

std::span<const std::uint8_t> ColumnRenderer::usable_rows(double theta_rad, int depth_theta,
                                                          const RaySource& source, size_t which) {
  const auto visible = visible_rows(depth_theta, source);
  const LineVolume& volume = view_.room.volume(source.line);
  if (!volume.masked()) return visible;
  // Visibility changes little within a column of the distances and is shared by its output columns;
  // masks have to hold to the pixel, so they are looked up where the samples really lie.
  auto& usable = scratch_->usable[which];
  usable.assign(visible.begin(), visible.end());
  if (view_.layers) scratch_->exact_omega = scratch_->omega;
  snap_to_layers(source);
  for (int next = 0; next < 2; ++next) {
    const SamplePositions at = find_samples(theta_rad, source, next).positions;
    SampleCheck check(volume, source.station + next);
    for (size_t row = 0; row < scratch_->omega.size(); ++row) {
      if (check.valid(at.offset_left[row], at.offset_right[row])) continue;
      usable[static_cast<size_t>(scratch_->mapping->nearest[row])] = 0;
    }
  }
  if (view_.layers) std::swap(scratch_->omega, scratch_->exact_omega);
  return usable;
}

void ColumnRenderer::weigh_sources(double theta_rad, int depth_theta,
                                   std::span<const RaySource> sources) {
  const size_t rows = static_cast<size_t>(view_.distances->size().height);
  scratch_->any_hidden = false;
  if (sources.size() == 1) {
    const auto visible = usable_rows(theta_rad, depth_theta, sources[0], 0);
    for (size_t row = 0; row < rows; ++row) {
      scratch_->hidden[row] = !visible[row];
      scratch_->any_hidden |= !visible[row];
    }
    return;
  }
  scratch_->source_weights.resize(std::max(scratch_->source_weights.size(), sources.size()));
  double span_m = 0.0;
  for (const RaySource& source : sources) span_m += std::fabs(source.d_p_m);
  // A source counts the more the nearer its line is: alone when the viewpoint is on it.
  float share[4];
  std::span<const std::uint8_t> visible[4];
  for (size_t i = 0; i < sources.size(); ++i) {
    visible[i] = usable_rows(theta_rad, depth_theta, sources[i], i);
    const double nearness =
        span_m > 0.0 ? 1.0 / (std::fabs(sources[i].d_p_m) / span_m + 1e-4) : 1.0;
    share[i] = static_cast<float>(sources[i].weight * nearness);
    scratch_->source_weights[i].resize(rows);
  }
  for (size_t row = 0; row < rows; ++row) {
    float total = 0.0f;
    for (size_t i = 0; i < sources.size(); ++i) total += visible[i][row] ? share[i] : 0.0f;
    scratch_->hidden[row] = total <= 0.0f;
    scratch_->any_hidden |= total <= 0.0f;
    const float scale = total > 0.0f ? static_cast<float>(kWeightOne) / total : 0.0f;
    for (size_t i = 0; i < sources.size(); ++i) {
      scratch_->source_weights[i][row] =
          static_cast<std::int16_t>(visible[i][row] ? share[i] * scale : 0.0f);
    }
  }
}

void ColumnRenderer::snap_to_layers(const RaySource& source) {
  if (!view_.layers) return;
  kernels_.snap_to_layers(scratch_->latitudes.table(), view_.output.height,
                          static_cast<float>(source.d_p_m), *view_.layers, scratch_->omega.data());
}

void ColumnRenderer::add_source(double theta_rad, const RaySource& source,
                                std::span<const std::int16_t> weights) {
  const int rows = view_.output.height;
  for (int row = 0; row < rows; ++row) {
    const auto i = static_cast<size_t>(row);
    scratch_->row_weight[i] = weights[static_cast<size_t>(scratch_->mapping->nearest[i])];
  }
  kernels_.accumulate_pair(find_samples(theta_rad, source, 0), find_samples(theta_rad, source, 1),
                           fixed_weight(source.fraction), scratch_->row_weight.data(), rows,
                           scratch_->sum.data());
}

StationSamples ColumnRenderer::find_samples(double theta_rad, const RaySource& source, int next) {
  const int station = source.station + next;
  const SamplePositions positions = scratch_->samples[next].positions();
  if (scratch_->rows_per_distance == 1) {
    return find_samples(theta_rad, source.line, station, 0, view_.output.height, positions);
  }
  const ColumnTarget target = target_of(theta_rad);
  const int depth_rows = view_.distances->size().height;
  kernels_.find_shifts(scratch_->depth_latitudes->table(), scratch_->depth_omega.data(), depth_rows,
                       offset_from(source.line, station, theta_rad), target,
                       scratch_->shift_u.data(), scratch_->shift_v.data());
  kernels_.place_shifted(scratch_->shift_u.data(), scratch_->shift_v.data(), depth_rows,
                         scratch_->rows_per_distance, scratch_->fraction.data(), target,
                         scratch_->row_shift_u.data(), scratch_->row_shift_v.data(), positions);
  return {view_.room.volume(source.line).column(station, 0).data(), positions};
}

StationSamples ColumnRenderer::find_samples(double theta_rad, int line, int station, int first_row,
                                            int rows, SamplePositions positions) {
  kernels_.find_samples(scratch_->latitudes.table(first_row), scratch_->omega.data() + first_row,
                        rows, offset_from(line, station, theta_rad), target_of(theta_rad),
                        positions);
  return {view_.room.volume(line).column(station, 0).data(), positions};
}

ColumnTarget ColumnRenderer::target_of(double theta_rad) const {
  const PanoramaSize captured = view_.room.panorama();
  const ColumnPosition position =
      split_column(pixel_from_angles({theta_rad, 0.0}, captured).u, captured.width);
  return {captured.width, captured.height, position.whole, position.part};
}

ColumnOffset ColumnRenderer::offset_from(int line, int station, double theta_rad) const {
  const Line& geometry = view_.room.grid().lines[static_cast<size_t>(line)];
  return column_offset(viewpoint_m() - geometry.stations[static_cast<size_t>(station)].position_m,
                       theta_rad);
}

Eigen::Vector3d ColumnRenderer::viewpoint_m() const {
  return {view_.plan.viewpoint().x_m, view_.plan.height_m(), view_.plan.viewpoint().z_m};
}

}  // namespace raywalk