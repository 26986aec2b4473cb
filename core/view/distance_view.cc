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

// Draws points of a map into the pixels they cover, keeping the nearest surface.
class Splat {
 public:
  Splat(PanoramaSize size, float* image) : size_(size), image_(image) {}

  // Point `i` of a column.
  void draw(const PointArrays& points, std::size_t i) const {
    const float omega = points.omega[i];
    const std::int32_t down = points.down[i];
    // Without branches, which would be mispredicted: marking a pixel twice changes nothing.
    for (float* const pixel : {image_ + points.left[i], image_ + points.right[i]}) {
      mark(omega, pixel);
      mark(omega, pixel + down);
    }
    if (points.is_wide[i] != 0) draw_wide(points, i);
  }

  // Prefetches where point `i` is drawn, because consecutive points often fall into a column that
  // is not cached.
  void prefetch(const PointArrays& points, std::size_t i) const {
    __builtin_prefetch(image_ + points.right[i], 1);
  }

 private:
  static void mark(float omega, float* pixel) { *pixel = std::max(*pixel, omega); }

  void draw_wide(const PointArrays& points, std::size_t i) const {
    const int first_row = std::max(points.first_row[i], 0);
    const int last_row = std::min(points.last_row[i], size_.height - 1);
    for (int u = points.first_column[i]; u <= points.last_column[i]; ++u) {
      float* const pixels = image_ + static_cast<std::size_t>(wrapped_column(u, size_.width)) *
                                         static_cast<std::size_t>(size_.height);
      for (int row = first_row; row <= last_row; ++row) mark(points.omega[i], pixels + row);
    }
  }

  PanoramaSize size_;
  float* image_;
};

// Draws two columns together: each point waits for the one before it in its column, which wrote
// the same pixels, and columns far apart do not wait for each other.
void splat(const Splat& into, const PointArrays& a, const PointArrays& b) {
  constexpr std::size_t kLookAhead = 24;
  const std::size_t rows = a.omega.size();
  for (std::size_t i = 0; i < rows; ++i) {
    if (i + kLookAhead < rows) {
      into.prefetch(a, i + kLookAhead);
      into.prefetch(b, i + kLookAhead);
    }
    into.draw(a, i);
    into.draw(b, i);
  }
}

// The next rows from `from` on that are taken from a map, as few runs as pay off: a few rows of
// other maps between them cost less than another run. Empty where there are none.
RowRun next_run(std::span<const std::int32_t> source, int from, std::int32_t map) {
  constexpr std::ptrdiff_t kGap = 8;
  const auto first = std::find(source.begin() + from, source.end(), map);
  auto end = first;
  for (auto next = first; next != source.end() && next - end <= kGap;
       next = std::find(end, source.end(), map)) {
    end = std::find_if(next, source.end(), [=](std::int32_t other) { return other != map; });
  }
  return {static_cast<int>(first - source.begin()), static_cast<int>(end - source.begin())};
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

void DistanceView::compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m) {
  std::vector<KeptMaps::Place> places;
  for (const MapStation& map : maps) places.push_back({map.line, map.map});
  maps_ = kept_.get(places);
  size_ = {};
  for (const auto& map : maps_) {
    if (map->size.width > size_.width) size_ = map->size;
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
  parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      project_map(*maps_[i], maps[i].position_m - viewpoint_m, projected_.data() + pixels * i);
    }
  });
  is_unseen_.resize(pixels);
  std::vector<int> unseen(static_cast<size_t>(size_.width));
  parallel_for(0, size_.width, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      unseen[static_cast<size_t>(theta)] = merge_column(maps, viewpoint_m, theta);
    }
  });
  double total_unseen = 0.0;
  for (const int count : unseen) total_unseen += count;
  unseen_share_ = total_unseen / static_cast<double>(pixels);
  const bool doubted = find_trust(maps, viewpoint_m);
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

bool DistanceView::find_trust(std::span<const MapStation> maps,
                              const Eigen::Vector3d& viewpoint_m) {
  std::vector<TrustedMap> trusted;
  for (size_t i = 0; i < maps.size(); ++i) {
    trusted.push_back({&maps_[i]->trust, (viewpoint_m - maps[i].position_m).cast<float>()});
  }
  trust_.clear();
  doubted_.clear();
  if (std::ranges::all_of(trusted, [](const auto& map) { return map.trust->everywhere(); })) {
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

void DistanceView::project_map(const KeptMap& map, const Eigen::Vector3d& offset_m,
                               float* omega) const {
  const int rows = map.size.height;
  const LatitudeTable latitudes(rows, rows);
  std::fill_n(omega, static_cast<size_t>(size_.width) * static_cast<size_t>(size_.height), kUnseen);
  const auto project = [&](int theta, PointArrays* points) {
    const double theta_rad = angles_from_pixel({double(theta), 0.0}, map.size).theta_rad;
    const double u = pixel_from_angles({theta_rad, 0.0}, size_).u;
    const ColumnTarget target{.width = size_.width,
                              .height = size_.height,
                              .u_whole = 0,
                              .u_part = static_cast<float>(u)};
    const float* omega_map =
        map.omega.data() + static_cast<size_t>(theta) * static_cast<size_t>(rows);
    column_kernels().project_points(latitudes.table(), omega_map, rows,
                                    column_offset(offset_m, theta_rad), target, points->points());
  };
  PointArrays points(rows), opposite(rows);
  const Splat into(size_, omega);
  const int half_turn = map.size.width / 2;
  for (int theta = 0; theta < half_turn; ++theta) {
    project(theta, &points);
    project(theta + half_turn, &opposite);
    splat(into, points, opposite);
  }
}

int DistanceView::merge_column(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m,
                               int theta) {
  const size_t rows = static_cast<size_t>(size_.height);
  const size_t pixels = static_cast<size_t>(size_.width) * rows;
  const float* candidates = projected_.data() + static_cast<size_t>(theta) * rows;
  float* omega = omega_.data() + static_cast<size_t>(theta) * rows;
  std::vector<float> nearest(candidates, candidates + rows);
  for (size_t i = 1; i < maps.size(); ++i) {
    const float* other = candidates + pixels * i;
    for (size_t row = 0; row < rows; ++row) nearest[row] = std::max(nearest[row], other[row]);
  }
  // The map that each pixel is taken from: the nearest of those that agree with the nearest
  // surface. Branchless, so that the compiler vectorises it.
  std::vector<std::int32_t> source(rows, -1);
  for (size_t i = maps.size(); i-- > 0;) {
    const float* other = candidates + pixels * i;
    for (size_t row = 0; row < rows; ++row) {
      const bool agrees = other[row] >= nearest[row] * (1.0f - tolerance_);
      omega[row] = agrees ? other[row] : omega[row];
      source[row] = agrees ? static_cast<std::int32_t>(i) : source[row];
    }
  }
  int unseen = 0;
  std::uint8_t* is_unseen = is_unseen_.data() + static_cast<size_t>(theta) * rows;
  for (size_t row = 0; row < rows; ++row) {
    const bool is_seen = nearest[row] >= 0.0f;
    is_unseen[row] = is_seen ? 0 : 1;
    unseen += is_seen ? 0 : 1;
    omega[row] = is_seen ? omega[row] : kUnseen;
    source[row] = nearest[row] > 0.0f ? source[row] : -1;
  }
  refine_column(maps, viewpoint_m, theta, source);
  return unseen;
}

// A projected point is up to half a pixel away from the centre of the pixel it is drawn to.
void DistanceView::refine_column(std::span<const MapStation> maps,
                                 const Eigen::Vector3d& viewpoint_m, int theta,
                                 std::span<const std::int32_t> source) {
  float* omega = omega_.data() + static_cast<size_t>(theta) * source.size();
  const double theta_rad = angles_from_pixel({double(theta), 0.0}, size_).theta_rad;
  std::vector<float> refined(source.size());
  for (size_t i = 0; i < maps.size(); ++i) {
    const KeptMap& map = *maps_[i];
    const ColumnPosition position =
        split_column(pixel_from_angles({theta_rad, 0.0}, map.size).u, map.size.width);
    const ColumnTarget target{map.size.width, map.size.height, position.whole, position.part};
    const ColumnOffset offset = column_offset(viewpoint_m - maps[i].position_m, theta_rad);
    const auto of_map = static_cast<std::int32_t>(i);
    for (RowRun run = next_run(source, 0, of_map); !run.empty();
         run = next_run(source, run.end, of_map)) {
      const auto begin = static_cast<size_t>(run.begin);
      column_kernels().refine_omega(latitudes_->table(run.begin), omega + begin,
                                    run.end - run.begin, offset, target, map.omega.data(),
                                    tolerance_, refined.data() + begin);
    }
  }
  for (size_t row = 0; row < source.size(); ++row) {
    if (source[row] >= 0) omega[row] = refined[row];
  }
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
