#include "core/view/distance_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/parallel.h"
#include "core/geometry/fast_math.h"
#include "core/view/column_arrays.h"
#include "core/view/row_table.h"

namespace raywalk {
namespace {

constexpr float kUnseen = -1.0f;

const DistanceVolume& volume_of(const Room& room, const MapStation& map) {
  return room.distances(map.line);
}

// Inverse of a stored distance; negative where it is unknown or of low confidence. Distances are
// clamped to at least a nanometre, because the inverse may overflow a float.
float stored_omega(float distance_m, std::uint8_t confidence) {
  constexpr float kLargest = 1e9f;
  const float omega = std::min(1.0f / distance_m, kLargest);
  // Branchless, so that the compiler vectorises it.
  const bool known = (confidence >= kMinConfidence) & (distance_m > 0.0f);
  return known ? omega : kUnseen;
}

// Draws the points of a column into the pixels they cover, keeping the nearest surface.
void splat(const PointArrays& column, const float* omega_map, PanoramaSize size, float* image) {
  // Prefetched, because consecutive points often fall into a column that is not cached.
  constexpr size_t kLookAhead = 24;
  const size_t rows = column.omega.size();
  for (size_t i = 0; i < rows; ++i) {
    if (i + kLookAhead < rows) {
      const int u = std::clamp(column.last_column[i + kLookAhead], 0, size.width - 1);
      const int row = std::clamp(column.first_row[i + kLookAhead], 0, size.height - 1);
      __builtin_prefetch(image + u * std::ptrdiff_t{size.height} + row, 1);
    }
    if (omega_map[i] < 0.0f) continue;
    const float omega = column.omega[i];
    const int first_row = std::max(column.first_row[i], 0);
    const int last_row = std::min(column.last_row[i], size.height - 1);
    const int first_u = column.first_column[i];
    const int last_u = column.last_column[i];
    // A point that is farther from the viewpoint than from the map may cover no pixel centre.
    if (first_row > last_row || first_u > last_u) continue;
    const auto column_of = [&](int u) {
      const int from_left = u < 0 ? u + size.width : u;
      const int wrapped = from_left >= size.width ? from_left - size.width : from_left;
      return image + static_cast<size_t>(wrapped) * static_cast<size_t>(size.height);
    };
    const auto mark = [&](float* pixel) { *pixel = std::max(*pixel, omega); };
    // Most points cover one or two columns and rows; a branch on the number would be mispredicted.
    const int second_row = std::min(first_row + 1, last_row);
    for (float* pixels : {column_of(first_u), column_of(std::min(first_u + 1, last_u))}) {
      mark(pixels + first_row);
      mark(pixels + second_row);
    }
    if (last_u - first_u < 2 && last_row - first_row < 2) continue;
    for (int u = first_u; u <= last_u; ++u) {
      float* const pixels = column_of(u);
      for (int row = first_row; row <= last_row; ++row) mark(pixels + row);
    }
  }
}

std::vector<MapStation> maps_by_distance(const Room& room, std::span<const int> lines,
                                         const Eigen::Vector3d& viewpoint_m) {
  std::vector<MapStation> all;
  for (const int line : lines) {
    const auto stations = room.distances(line).stations();
    for (int map = 0; map < static_cast<int>(stations.size()); ++map) {
      const int station = stations[static_cast<size_t>(map)];
      const Line& geometry = room.grid().lines[static_cast<size_t>(line)];
      all.push_back(
          {line, map, station, geometry.stations[static_cast<size_t>(station)].position_m});
    }
  }
  const auto distance = [&](const MapStation& map) {
    return (map.position_m - viewpoint_m).norm();
  };
  std::stable_sort(all.begin(), all.end(), [&](const MapStation& a, const MapStation& b) {
    return distance(a) < distance(b);
  });
  return all;
}

bool is_near(const MapStation& map, std::span<const MapStation> others, double gap_m) {
  return std::any_of(others.begin(), others.end(), [&](const MapStation& other) {
    return (other.position_m - map.position_m).norm() < gap_m;
  });
}

}  // namespace

std::vector<MapStation> nearest_maps(const Room& room, std::span<const int> lines,
                                     const Eigen::Vector3d& viewpoint_m, double gap_m,
                                     int most_per_line, int most) {
  std::vector<MapStation> chosen;
  for (const MapStation& map : maps_by_distance(room, lines, viewpoint_m)) {
    if (static_cast<int>(chosen.size()) == most) break;
    const auto of_line = std::count_if(chosen.begin(), chosen.end(), [&](const MapStation& other) {
      return other.line == map.line;
    });
    if (of_line < most_per_line && !is_near(map, chosen, gap_m)) chosen.push_back(map);
  }
  return chosen;
}

std::vector<MapStation> farther_maps(const Room& room, std::span<const MapStation> near,
                                     const Eigen::Vector3d& viewpoint_m, int most) {
  std::vector<int> lines(room.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  std::vector<MapStation> chosen;
  for (const MapStation& map : maps_by_distance(room, lines, viewpoint_m)) {
    if (static_cast<int>(chosen.size()) == most) break;
    const double gap_m = 0.25 * (map.position_m - viewpoint_m).norm();
    // A map at the viewpoint itself is already among the nearest.
    if (gap_m > 0.0 && !is_near(map, near, gap_m) && !is_near(map, chosen, gap_m)) {
      chosen.push_back(map);
    }
  }
  return chosen;
}

OmegaRange omega_range(const Room& room, const MapStation& map) {
  const DistanceVolume& volume = volume_of(room, map);
  float least = std::numeric_limits<float>::infinity();
  float most = 0.0f;
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distance = volume.distance_column(map.map, theta);
    const auto confidence = volume.confidence_column(map.map, theta);
    for (size_t row = 0; row < distance.size(); ++row) {
      const float omega = stored_omega(distance[row], confidence[row]);
      if (omega < 0.0f) continue;
      least = std::min(least, omega);
      most = std::max(most, omega);
    }
  }
  return {std::min(least, most), most};
}

void DistanceView::compute(const Room& room, std::span<const MapStation> maps,
                           const Eigen::Vector3d& viewpoint_m) {
  size_ = {};
  for (const MapStation& map : maps) {
    const PanoramaSize size = volume_of(room, map).size();
    if (size.width > size_.width) size_ = size;
  }
  tolerance_ = static_cast<float>(
      std::min(0.25, std::tan(radians_from_degrees(80.0)) * kTwoPi / size_.width));
  if (!latitudes_ || latitudes_rows_ != size_.height) {
    latitudes_ = std::make_unique<LatitudeTable>(size_.height, size_.height);
    latitudes_rows_ = size_.height;
  }
  const size_t pixels = static_cast<size_t>(size_.width) * static_cast<size_t>(size_.height);
  omega_.resize(pixels);
  projected_.resize(pixels * maps.size());
  stored_.resize(maps.size());
  parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      project_map(room, maps[static_cast<size_t>(i)], viewpoint_m, stored_[static_cast<size_t>(i)],
                  projected_.data() + pixels * static_cast<size_t>(i));
    }
  });
  is_unseen_.resize(pixels);
  std::vector<int> unseen(static_cast<size_t>(size_.width));
  parallel_for(0, size_.width, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      unseen[static_cast<size_t>(theta)] = merge_column(room, maps, viewpoint_m, theta);
    }
  });
  double total_unseen = 0.0;
  for (const int count : unseen) total_unseen += count;
  unseen_share_ = total_unseen / static_cast<double>(pixels);
  const bool doubted = find_trust(room, maps, viewpoint_m);
  if (total_unseen > 0.0) {
    parallel_for(0, size_.width / 2, 16, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        const auto at = static_cast<size_t>(theta);
        if (unseen[at] + unseen[at + static_cast<size_t>(size_.width / 2)] > 0) fill_unseen(theta);
      }
    });
    filled_ = omega_;
    parallel_for(0, size_.width, 16, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        if (unseen[static_cast<size_t>(theta)] > 0) smooth_filled(theta);
      }
    });
  }
  if (doubted) smooth_doubted();
}

bool DistanceView::find_trust(const Room& room, std::span<const MapStation> maps,
                              const Eigen::Vector3d& viewpoint_m) {
  std::vector<TrustedMap> trusted(maps.size());
  parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const MapStation& map = maps[static_cast<size_t>(i)];
      trusted[static_cast<size_t>(i)].trust.compute(volume_of(room, map), map.map);
      trusted[static_cast<size_t>(i)].offset_m = (viewpoint_m - map.position_m).cast<float>();
    }
  });
  trust_.clear();
  doubted_.clear();
  if (std::ranges::all_of(trusted, [](const auto& map) { return map.trust.everywhere(); })) {
    return false;
  }
  smooth_.compute(omega_, size_, trusted);
  return true;
}

void DistanceView::smooth_doubted() {
  const auto rows = static_cast<size_t>(size_.height);
  trust_.resize(omega_.size());
  doubted_.resize(static_cast<size_t>(size_.width));
  parallel_for(0, size_.width, 16, [&](int begin, int end) {
    for (auto theta = static_cast<size_t>(begin); theta < static_cast<size_t>(end); ++theta) {
      const std::span trust(trust_.data() + theta * rows, rows);
      doubted_[theta] = smooth_.trust(static_cast<int>(theta), trust) ? 1 : 0;
      if (doubted_[theta] == 0) continue;
      smooth_.smooth(static_cast<int>(theta), trust, {omega_.data() + theta * rows, rows});
    }
  });
}

void DistanceView::project_map(const Room& room, const MapStation& map,
                               const Eigen::Vector3d& viewpoint_m, std::vector<float>& stored,
                               float* omega) const {
  const DistanceVolume& volume = volume_of(room, map);
  const int rows = volume.size().height;
  const LatitudeTable latitudes(rows, rows);
  const Eigen::Vector3d offset_m = map.position_m - viewpoint_m;
  PointArrays column(rows);
  stored.resize(static_cast<size_t>(volume.size().width) * static_cast<size_t>(rows));
  std::fill_n(omega, static_cast<size_t>(size_.width) * static_cast<size_t>(size_.height), kUnseen);
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distance = volume.distance_column(map.map, theta);
    const auto confidence = volume.confidence_column(map.map, theta);
    float* omega_map = stored.data() + static_cast<size_t>(theta) * distance.size();
    for (size_t row = 0; row < distance.size(); ++row) {
      omega_map[row] = stored_omega(distance[row], confidence[row]);
    }
    const double theta_rad = angles_from_pixel({double(theta), 0.0}, volume.size()).theta_rad;
    const double u = pixel_from_angles({theta_rad, 0.0}, size_).u;
    const ColumnTarget target{.width = size_.width,
                              .height = size_.height,
                              .u_whole = 0,
                              .u_part = static_cast<float>(u)};
    // Unknown pixels are projected with the others and skipped by splat().
    column_kernels().project_points(latitudes.table(), omega_map, rows,
                                    column_offset(offset_m, theta_rad), target, column.points());
    splat(column, omega_map, size_, omega);
  }
}

int DistanceView::merge_column(const Room& room, std::span<const MapStation> maps,
                               const Eigen::Vector3d& viewpoint_m, int theta) {
  const size_t rows = static_cast<size_t>(size_.height);
  const size_t pixels = static_cast<size_t>(size_.width) * rows;
  const float* candidates = projected_.data() + static_cast<size_t>(theta) * rows;
  float* omega = omega_.data() + static_cast<size_t>(theta) * rows;
  std::copy_n(candidates, rows, omega);
  for (size_t i = 1; i < maps.size(); ++i) {
    const float* other = candidates + pixels * i;
    for (size_t row = 0; row < rows; ++row) omega[row] = std::max(omega[row], other[row]);
  }
  // The map that each pixel is taken from: the nearest of those that agree with the nearest
  // surface.
  std::vector<std::int8_t> source(rows, -1);
  int unseen = 0;
  std::uint8_t* is_unseen = is_unseen_.data() + static_cast<size_t>(theta) * rows;
  for (size_t row = 0; row < rows; ++row) {
    is_unseen[row] = omega[row] < 0.0f ? 1 : 0;
    unseen += is_unseen[row];
    if (omega[row] <= 0.0f) continue;
    size_t map = 0;
    while (candidates[pixels * map + row] < omega[row] * (1.0f - tolerance_)) ++map;
    source[row] = static_cast<std::int8_t>(map);
    omega[row] = candidates[pixels * map + row];
  }
  // A projected point is up to half a pixel away from the centre of the pixel it is drawn to.
  const double theta_rad = angles_from_pixel({double(theta), 0.0}, size_).theta_rad;
  std::vector<float> refined(rows);
  for (size_t i = 0; i < maps.size(); ++i) {
    const auto of_map = static_cast<std::int8_t>(i);
    const auto first = std::find(source.begin(), source.end(), of_map);
    if (first == source.end()) continue;
    const auto begin = static_cast<size_t>(first - source.begin());
    const auto end =
        static_cast<size_t>(source.rend() - std::find(source.rbegin(), source.rend(), of_map));
    const PanoramaSize map_size = volume_of(room, maps[i]).size();
    const ColumnPosition position =
        split_column(pixel_from_angles({theta_rad, 0.0}, map_size).u, map_size.width);
    const ColumnTarget target{map_size.width, map_size.height, position.whole, position.part};
    column_kernels().refine_omega(latitudes_->table(static_cast<int>(begin)), omega + begin,
                                  static_cast<int>(end - begin),
                                  column_offset(viewpoint_m - maps[i].position_m, theta_rad),
                                  target, stored_[i].data(), tolerance_, refined.data() + begin);
    for (size_t row = begin; row < end; ++row) {
      if (source[row] == of_map) omega[row] = refined[row];
    }
  }
  return unseen;
}

void DistanceView::fill_unseen(int theta) {
  const int rows = size_.height;
  float* down = omega_.data() + static_cast<size_t>(theta) * static_cast<size_t>(rows);
  float* up =
      omega_.data() + static_cast<size_t>(theta + size_.width / 2) * static_cast<size_t>(rows);
  const auto ring = [&](int i) -> float& {
    const int at = (i % (2 * rows) + 2 * rows) % (2 * rows);
    return at < rows ? down[at] : up[2 * rows - 1 - at];
  };
  int seen = 0;
  while (seen < 2 * rows && ring(seen) < 0.0f) ++seen;
  if (seen == 2 * rows) {
    std::fill_n(down, rows, 0.0f);
    std::fill_n(up, rows, 0.0f);
    return;
  }
  for (int i = seen; i < seen + 2 * rows;) {
    int next = i + 1;
    while (ring(next) < 0.0f) ++next;
    const float farther = std::min(ring(i), ring(next));
    for (int gap = i + 1; gap < next; ++gap) ring(gap) = farther;
    i = next;
  }
}

void DistanceView::smooth_filled(int theta) {
  // What a row is filled from lies above or below: within this angle it is mostly one surface.
  constexpr double kReach_rad = radians_from_degrees(4.0);
  const int reach = std::max(1, static_cast<int>(std::lround(kReach_rad / kTwoPi * size_.width)));
  const auto rows = static_cast<size_t>(size_.height);
  float* omega = omega_.data() + static_cast<size_t>(theta) * rows;
  std::vector<float> around;
  for (size_t row = 0; row < rows; ++row) {
    if (is_unseen_[static_cast<size_t>(theta) * rows + row] == 0) continue;
    around.clear();
    for (int u = theta - reach; u <= theta + reach; ++u) {
      const auto column = static_cast<size_t>((u + size_.width) % size_.width);
      const size_t pixel = column * rows + row;
      if (is_unseen_[pixel] != 0) around.push_back(filled_[pixel]);
    }
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::ranges::nth_element(around, middle);
    omega[row] = *middle;
  }
}

MapLookup look_up(const Room& room, const MapStation& map, const Eigen::Vector3f& direction,
                  float omega, const Eigen::Vector3d& viewpoint_m, float tolerance) {
  const DistanceVolume& volume = volume_of(room, map);
  const PanoramaSize size = volume.size();
  const Eigen::Vector3f seen = direction + omega * (viewpoint_m - map.position_m).cast<float>();
  const float plan = std::sqrt(seen.x() * seen.x() + seen.z() * seen.z());
  MapLookup result;
  result.omega_there = omega / std::max(1e-30f, std::sqrt(plan * plan + seen.y() * seen.y()));
  const float width = static_cast<float>(size.width);
  const float height = static_cast<float>(size.height);
  const float u = (fast_atan2(seen.x(), seen.z()) / float(kTwoPi) + 0.5f) * width - 0.5f;
  const float v = std::clamp((0.5f - fast_atan2(seen.y(), plan) / float(kPi)) * height - 0.5f, 0.0f,
                             height - 1.0f);
  const int left = static_cast<int>(u + 1.0f) - 1;  // floor: u is at least -1
  const int upper = std::min(static_cast<int>(v), size.height - 2);
  const float right_part = u - static_cast<float>(left);
  const float lower_part = v - static_cast<float>(upper);
  float sum = 0.0f;
  float total = 0.0f;
  float best_part = -1.0f;
  for (int side = 0; side < 2; ++side) {
    const int column = (left + side + size.width) % size.width;
    const auto distance = volume.distance_column(map.map, column);
    const auto confidence = volume.confidence_column(map.map, column);
    for (int below = 0; below < 2; ++below) {
      const auto row = static_cast<size_t>(upper) + static_cast<size_t>(below);
      const float held = stored_omega(distance[row], confidence[row]);
      if (held < 0.0f) continue;
      result.omega_around = std::max(result.omega_around, held);
      const float part = (side == 0 ? 1.0f - right_part : right_part) *
                         (below == 0 ? 1.0f - lower_part : lower_part);
      if (part > best_part) {
        best_part = part;
        result.omega_map = held;
      }
      if (std::fabs(held - result.omega_there) <= tolerance * result.omega_there) {
        sum += part * held;
        total += part;
      }
    }
  }
  if (total > 0.01f) result.omega_map = sum / total;
  return result;
}

}  // namespace raywalk
