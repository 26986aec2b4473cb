#include "core/view/distance_view.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/view/column_arrays.h"
#include "core/view/row_table.h"

namespace raywalk {
namespace {

constexpr float kUnseen = -1.0f;

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

}  // namespace

float surface_tolerance_of_view(int width) {
  return static_cast<float>(std::min(0.25, std::tan(radians_from_degrees(80.0)) * kTwoPi / width));
}

void DistanceView::compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m) {
  maps_ = read(maps);
  opposite_ = this;
  gather(maps, {viewpoint_m});
  fill(this, size_.width / 2);
  smooth();
}

void DistanceView::compute_stereo(std::span<const MapStation> maps, const EyeCircle& circle,
                                  DistanceView* left, DistanceView* right) {
  left->maps_ = left->read(maps);
  right->maps_ = left->maps_;
  left->opposite_ = right;
  right->opposite_ = left;
  left->gather(maps, circle);
  right->projected_.swap(left->projected_);  // one eye after the other in the same memory
  right->gather(maps, circle.opposite());
  left->projected_.swap(right->projected_);
  left->fill(right, left->size_.width);
  left->smooth();
  right->smooth();
}

std::vector<std::shared_ptr<const KeptMap>> DistanceView::read(std::span<const MapStation> maps) {
  std::vector<KeptMaps::Place> places;
  for (const MapStation& map : maps) places.push_back({map.line, map.map});
  return kept_.get(places);
}

void DistanceView::gather(std::span<const MapStation> maps, const EyeCircle& circle) {
  eye_ = circle;
  size_ = {};
  for (const auto& map : maps_) {
    if (map->size.width > size_.width) size_ = map->size;
  }
  tolerance_ = surface_tolerance_of_view(size_.width);
  if (!latitudes_ || latitudes_rows_ != size_.height) {
    latitudes_ = std::make_unique<LatitudeTable>(size_.height, size_.height);
    latitudes_rows_ = size_.height;
  }
  const size_t pixels = static_cast<size_t>(size_.width) * static_cast<size_t>(size_.height);
  omega_.resize(pixels);
  projected_.resize(pixels * maps.size());
  parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      project_map(*maps_[i], maps[i].position_m - eye_.centre_m, projected_.data() + pixels * i);
    }
  });
  is_unseen_.resize(pixels);
  unseen_.resize(static_cast<size_t>(size_.width));
  parallel_for(0, size_.width, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      unseen_[static_cast<size_t>(theta)] = merge_column(maps, theta);
    }
  });
  double total_unseen = 0.0;
  for (const int count : unseen_) total_unseen += count;
  unseen_share_ = total_unseen / static_cast<double>(pixels);
  is_doubted_ = find_trust(maps);
}

void DistanceView::fill(DistanceView* opposite, int columns) {
  if (unseen_share_ + opposite->unseen_share_ == 0.0) return;
  parallel_for(0, columns, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      const int behind = (theta + size_.width / 2) % size_.width;
      if (unseen_[static_cast<size_t>(theta)] + opposite->unseen_[static_cast<size_t>(behind)] > 0)
        fill_unseen(theta, opposite);
    }
  });
}

void DistanceView::smooth() {
  if (unseen_share_ > 0.0) {
    filled_ = omega_;
    parallel_for(0, size_.width, 16, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        if (unseen_[static_cast<size_t>(theta)] > 0) smooth_filled(theta);
      }
    });
  }
  if (is_doubted_) smooth_doubted();
}

bool DistanceView::find_trust(std::span<const MapStation> maps) {
  std::vector<TrustedMap> trusted;
  for (size_t i = 0; i < maps.size(); ++i) {
    trusted.push_back({&maps_[i]->trust, maps[i].position_m});
  }
  trust_.clear();
  doubted_.clear();
  if (std::ranges::all_of(trusted, [](const auto& map) { return map.trust->everywhere(); })) {
    return false;
  }
  smooth_.compute(omega_, size_, eye_, trusted);
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
                                    column_offset(offset_m, theta_rad),
                                    static_cast<float>(eye_.radius_m), target, points->points());
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

int DistanceView::merge_column(std::span<const MapStation> maps, int theta) {
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
  refine_column(maps, theta, source);
  return unseen;
}

// A projected point is up to half a pixel away from the centre of the pixel it is drawn to.
void DistanceView::refine_column(std::span<const MapStation> maps, int theta,
                                 std::span<const std::int32_t> source) {
  float* omega = omega_.data() + static_cast<size_t>(theta) * source.size();
  const double theta_rad = angles_from_pixel({double(theta), 0.0}, size_).theta_rad;
  const Eigen::Vector3d eye_m = eye_.position_m(theta_rad);
  std::vector<float> refined(source.size());
  for (size_t i = 0; i < maps.size(); ++i) {
    const KeptMap& map = *maps_[i];
    const ColumnPosition position =
        split_column(pixel_from_angles({theta_rad, 0.0}, map.size).u, map.size.width);
    const ColumnTarget target{map.size.width, map.size.height, position.whole, position.part};
    const ColumnOffset offset = column_offset(eye_m - maps[i].position_m, theta_rad);
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

void DistanceView::fill_unseen(int theta, DistanceView* opposite) {
  const int rows = size_.height;
  const int behind = (theta + size_.width / 2) % size_.width;
  float* down = omega_.data() + static_cast<size_t>(theta) * static_cast<size_t>(rows);
  float* up = opposite->omega_.data() + static_cast<size_t>(behind) * static_cast<size_t>(rows);
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

}  // namespace raywalk
