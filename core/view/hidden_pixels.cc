// Pixels hidden from the lines in use: filled from other stations, or stretched.
#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"
#include "core/view/column_scratch.h"
#include "core/view/sample_check.h"

namespace raywalk {

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

bool ColumnRenderer::is_left_out(const MapStation& map, const Eigen::Vector3f& direction,
                                 float omega) const {
  const LeftOutPixels& left_out = view_.room.distances(map.line).left_out();
  if (!left_out.any(map.station)) return false;
  const Eigen::Vector3d seen =
      direction.cast<double>() + double(omega) * (viewpoint_m() - map.position_m);
  const PixelPosition at = pixel_from_angles(angles_from_direction(seen), left_out.size());
  const auto row = static_cast<int>(std::lround(at.v));
  const auto column = static_cast<int>(std::lround(at.u));
  for (int u = column - 1; u <= column + 1; ++u) {
    for (const RowRun& run : left_out.rows(map.station, wrapped_column(u, left_out.size().width))) {
      if (row - 1 < run.end && row + 1 >= run.begin) return true;
    }
  }
  return false;
}

int ColumnRenderer::find_fill_station(int depth_theta, int depth_row) {
  const DistanceView& distances = *view_.distances;
  const float omega = distances.column(depth_theta)[depth_row];
  const Eigen::Vector3f direction =
      direction_from_angles(
          angles_from_pixel({double(depth_theta), double(depth_row)}, distances.size()))
          .cast<float>();
  const float tolerance = distances.surface_tolerance();
  const float* const trust = distances.trust(depth_theta);
  if (trust != nullptr && trust[depth_row] < 0.5f) {
    return find_unmasked_station(direction, omega);
  }
  // Next to a silhouette a captured pixel is part foreground: a station that sees the point away
  // from nearer surfaces is preferred to a nearer one that sees it at a silhouette.
  int just_sees = Scratch::kNone;
  // What moved is shown only where no other station sees the place.
  int shows_moved = Scratch::kNone;
  for (size_t i = 0; i < view_.fill_maps.size(); ++i) {
    const MapLookup there =
        look_up(view_.room, view_.fill_maps[i], direction, omega, viewpoint_m(), tolerance);
    const float hides = there.omega_there * (1.0f + tolerance);
    if (there.omega_map < 0.0f || there.omega_map > hides) continue;
    if (!is_unmasked(view_.fill_maps[i], direction, omega)) continue;
    if (is_left_out(view_.fill_maps[i], direction, omega)) {
      if (shows_moved == Scratch::kNone) shows_moved = static_cast<int>(i);
      continue;
    }
    if (there.omega_around <= hides) return static_cast<int>(i);
    if (just_sees == Scratch::kNone) just_sees = static_cast<int>(i);
  }
  return just_sees != Scratch::kNone ? just_sees : shows_moved;
}

int ColumnRenderer::fill_of(int depth_theta, int depth_row) {
  int& fill = scratch_->depth.fill[static_cast<size_t>(depth_row)];
  if (fill == Scratch::kUnknown) fill = find_fill_station(depth_theta, depth_row);
  return fill;
}

int ColumnRenderer::find_unmasked_station(const Eigen::Vector3f& direction, float omega) const {
  // Without a distance to rely on it is not known which stations see the point, and farther
  // stations would show something else.
  const size_t nearest = std::min(view_.fill_maps.size(), size_t{2});
  for (size_t i = 0; i < nearest; ++i) {
    if (is_unmasked(view_.fill_maps[i], direction, omega)) return static_cast<int>(i);
  }
  return Scratch::kNone;
}

void ColumnRenderer::fill_hidden(double theta_rad, int depth_theta, std::uint8_t* rgb) {
  const int depth_rows = view_.distances->size().height;
  const auto hidden = [&](int depth_row) {
    return scratch_->hidden[static_cast<size_t>(depth_row)] != 0;
  };
  for (int depth_row = 0; depth_row < depth_rows;) {
    const int begin = scratch_->mapping->first_row[static_cast<size_t>(depth_row)];
    if (!hidden(depth_row)) {
      ++depth_row;
      continue;
    }
    const int fill = fill_of(depth_theta, depth_row);
    do {
      ++depth_row;
    } while (depth_row < depth_rows && hidden(depth_row) &&
             fill_of(depth_theta, depth_row) == fill);
    const int end = scratch_->mapping->first_row[static_cast<size_t>(depth_row)];
    if (begin == end) continue;
    if (fill == Scratch::kNone) {
      leave_unresolved({begin, end});
    } else {
      show_station(theta_rad, view_.fill_maps[static_cast<size_t>(fill)], {begin, end}, rgb);
    }
  }
}

bool ColumnRenderer::shows_moved(const MapStation& map, int row) const {
  const DistanceView& distances = *view_.distances;
  const int theta = scratch_->depth.theta;
  const int depth_row = scratch_->mapping->nearest[static_cast<size_t>(row)];
  const Eigen::Vector3d direction = direction_from_angles(
      angles_from_pixel({double(theta), double(depth_row)}, distances.size()));
  return is_left_out(map, direction.cast<float>(), distances.column(theta)[depth_row]);
}

std::uint8_t ColumnRenderer::hidden_part(int row) const {
  return scratch_
      ->hidden[static_cast<size_t>(scratch_->mapping->nearest[static_cast<size_t>(row)])];
}

void ColumnRenderer::leave_unresolved(RowRun rows) {
  for (int row = rows.begin; row < rows.end; ++row) {
    if (hidden_part(row) == kSeen) add_unresolved({row, row + 1});
  }
}

void ColumnRenderer::show_station(double theta_rad, const MapStation& map, RowRun rows,
                                  std::uint8_t* rgb) {
  const int count = rows.end - rows.begin;
  const StationSamples samples =
      find_run(theta_rad, map.line, map.station, rows, scratch_->samples[0].positions());
  std::uint8_t* const shown = scratch_->fill.data();
  scratch_->reader.mix(
      {.line = map.line, .count = 1, .station = {map.station}, .at = {samples}, .rows = count},
      shown);
  const LineVolume& volume = view_.room.volume(map.line);
  const LeftOutPixels& left_out = view_.room.distances(map.line).left_out();
  const bool anything_moved = left_out.any(map.station);
  SampleCheck masks(volume, map.station);
  LeftOutCheck moved(left_out, map.station, volume.panorama());
  for (int i = 0; i < count; ++i) {
    const int row = rows.begin + i;
    const std::int32_t left = samples.positions.offset_left[i];
    const std::int32_t right = samples.positions.offset_right[i];
    // A sample may be masked or left out where an interpolated distance differs from those of the
    // rows around.
    if ((volume.masked() && !masks.valid(left, right)) ||
        (anything_moved && !moved.valid(left, right) && !shows_moved(map, row))) {
      leave_unresolved({row, row + 1});
      continue;
    }
    const int part = hidden_part(row);
    for (int c = 0; c < 3; ++c) {
      std::uint8_t& held = rgb[3 * row + c];
      held = static_cast<std::uint8_t>(held + ((shown[3 * i + c] - held) * part) / kSeen);
    }
    if (part > kSeen / 2) ++counts_.filled;
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

void ColumnRenderer::render_row(int u, std::span<const RaySource> sources, int row,
                                std::uint8_t* rgb) {
  const auto depth_row = static_cast<size_t>(scratch_->mapping->nearest[static_cast<size_t>(row)]);
  if (scratch_->hidden[depth_row] == kSeen) return;  // filled already
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
  const auto omega = [&](int row) {
    return scratch_
        ->depth_omega[static_cast<size_t>(scratch_->mapping->nearest[static_cast<size_t>(row)])];
  };
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

}  // namespace raywalk
