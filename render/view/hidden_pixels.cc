// Pixels hidden from the lines in use: filled from other stations, or stretched.
#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"
#include "render/view/column_scratch.h"
#include "render/view/sample_check.h"

namespace raywalk::render {

bool ColumnRenderer::is_unmasked(const MapStation& map, const Eigen::Vector3f& direction,
                                 float omega) const {
  const LineVolume& volume = view_.room.volume(map.line);
  if (!volume.masked()) return true;
  const PanoramaSize captured = volume.panorama();
  const Eigen::Vector3d seen =
      direction.cast<double>() + double(omega) * (viewpoint_m() - map.position_m);
  const SphereAngles angles = angles_from_direction(seen);
  const PixelPosition at = pixel_from_angles(angles, captured);
  // The pixels that a pixel of the distances covers there: more if the station is nearer, and more
  // columns towards a pole.
  const double rows_per_distance = double(captured.height) / view_.distances->size().height;
  const double radius = 0.5 + rows_per_distance * std::max(1.0, 1.0 / seen.norm());
  const double columns =
      std::min(radius / std::max(1e-6, std::cos(angles.phi_rad)), 0.5 * captured.width);
  const auto first_row = static_cast<int>(std::floor(at.v - radius));
  const auto last_row = static_cast<int>(std::ceil(at.v + radius));
  const int first = static_cast<int>(std::floor(at.u - columns));
  const int last = static_cast<int>(std::ceil(at.u + columns));
  for (int u = first; u <= last; ++u) {
    const int theta = wrapped_column(u, captured.width);
    const RowRun rows = volume.valid_rows(map.station, theta);
    if (std::max(first_row, 0) < rows.begin || std::min(last_row, captured.height - 1) >= rows.end)
      return false;
  }
  return true;
}

int ColumnRenderer::find_fill_station(int depth_theta, int depth_row) {
  const DistanceView& distances = *view_.distances;
  const float omega = distances.column(depth_theta)[depth_row];
  const Eigen::Vector3f direction =
      direction_from_angles(
          angles_from_pixel({double(depth_theta), double(depth_row)}, distances.size()))
          .cast<float>();
  const float tolerance = distances.surface_tolerance();
  // Next to a silhouette a captured pixel is part foreground: a station that sees the point away
  // from nearer surfaces is preferred to a nearer one that sees it at a silhouette.
  int just_sees = Scratch::kNone;
  for (size_t i = 0; i < view_.fill_maps.size(); ++i) {
    const MapLookup there =
        look_up(view_.room, view_.fill_maps[i], direction, omega, viewpoint_m(), tolerance);
    const float hides = there.omega_there * (1.0f + tolerance);
    if (there.omega_map < 0.0f || there.omega_map > hides) continue;
    if (!is_unmasked(view_.fill_maps[i], direction, omega)) continue;
    if (there.omega_around <= hides) return static_cast<int>(i);
    if (just_sees == Scratch::kNone) just_sees = static_cast<int>(i);
  }
  return just_sees;
}

void ColumnRenderer::fill_hidden(double theta_rad, int depth_theta, std::uint8_t* rgb) {
  const int depth_rows = view_.distances->size().height;
  const auto fill_of = [&](int depth_row) {
    int& fill = scratch_->depth.fill[static_cast<size_t>(depth_row)];
    if (fill == Scratch::kUnknown) fill = find_fill_station(depth_theta, depth_row);
    return fill;
  };
  const auto hidden = [&](int depth_row) {
    return scratch_->hidden[static_cast<size_t>(depth_row)] != 0;
  };
  scratch_->unresolved.clear();
  for (int depth_row = 0; depth_row < depth_rows;) {
    const int begin = scratch_->mapping->first_row[static_cast<size_t>(depth_row)];
    if (!hidden(depth_row)) {
      ++depth_row;
      continue;
    }
    const int fill = fill_of(depth_row);
    do {
      ++depth_row;
    } while (depth_row < depth_rows && hidden(depth_row) && fill_of(depth_row) == fill);
    const int end = scratch_->mapping->first_row[static_cast<size_t>(depth_row)];
    if (begin == end) continue;
    if (fill == Scratch::kNone) add_unresolved({begin, end});
    if (fill >= 0) {
      const MapStation& map = view_.fill_maps[static_cast<size_t>(fill)];
      const StationSamples samples = find_samples(theta_rad, map.line, map.station, begin,
                                                  end - begin, scratch_->samples[0].positions());
      scratch_->reader.mix({.line = map.line,
                            .count = 1,
                            .station = {map.station},
                            .at = {samples},
                            .rows = end - begin},
                           rgb + 3 * begin);
      counts_.filled += end - begin;
      unresolve_masked(map, begin, end, samples.positions);
    }
  }
}

void ColumnRenderer::add_unresolved(RowRun run) {
  auto& unresolved = scratch_->unresolved;
  if (!unresolved.empty() && unresolved.back().end == run.begin) {
    unresolved.back().end = run.end;
  } else {
    unresolved.push_back(run);
  }
}

void ColumnRenderer::unresolve_masked(const MapStation& map, int begin, int end,
                                      SamplePositions positions) {
  const LineVolume& volume = view_.room.volume(map.line);
  if (!volume.masked()) return;
  SampleCheck check(volume, map.station);
  for (int i = 0; i < end - begin; ++i) {
    if (check.valid(positions.offset_left[i], positions.offset_right[i])) continue;
    add_unresolved({begin + i, begin + i + 1});
    --counts_.filled;
  }
}

void ColumnRenderer::render_row(int u, std::span<const RaySource> sources, int row,
                                std::uint8_t* rgb) {
  const auto depth_row = static_cast<size_t>(scratch_->mapping->nearest[static_cast<size_t>(row)]);
  if (scratch_->hidden[depth_row] != 0) return;  // filled already
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  const std::uint8_t beyond = rgb[3 * row + 3];
  if (sources.size() == 1) {
    mix_source(u, theta_rad, sources[0], {row, row + 1}, rgb);
  } else {
    blend_sources(u, theta_rad, sources, {row, row + 1}, rgb);
  }
  rgb[3 * row + 3] = beyond;
}

void ColumnRenderer::stretch_unresolved(int u, std::span<const RaySource> sources, RowRun rendered,
                                        std::uint8_t* rgb) {
  const int rows = view_.output.height;
  const auto omega = [&](int row) { return scratch_->omega[static_cast<size_t>(row)]; };
  for (const RowRun& run : scratch_->unresolved) {
    const int above = run.begin - 1;
    const int below = run.end;
    const bool below_is_farther = below < rows && (above < 0 || omega(below) < omega(above));
    const int from = below_is_farther ? below : above;
    if (from < 0 && view_.room.masked()) {
      fill_empty(u, rgb);
      return;
    }
    counts_.stretched += run.end - run.begin;
    if (from < 0) continue;
    if (from < rendered.begin || from >= rendered.end) render_row(u, sources, from, rgb);
    for (int row = run.begin; row < run.end; ++row) std::copy_n(rgb + 3 * from, 3, rgb + 3 * row);
  }
}

}  // namespace raywalk::render
