#include "core/view/distance_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

constexpr float kUnseen = -1.0f;

// Where the points of a column of a map are in the view, and how far the pixels reach that they
// cover.
struct DrawnPoints {
  explicit DrawnPoints(int rows)
      : pixel(static_cast<std::size_t>(rows)),
        inverse(pixel.size()),
        reach_u(pixel.size()),
        reach_v(pixel.size()) {}
  std::vector<std::int32_t> pixel;
  std::vector<float> inverse, reach_u, reach_v;
};

struct DrawnColumn {
  const float* inverse;
  int rows;
  Offset from_eye;  // of the map's station, in the column's frame
  float radius_m;   // of the circle of eyes
  float u;          // the column's place in the view, from its left border
};

// A point is seen in the column whose eye sees it: the ray touches the circle of eyes, so that it
// is turned by asin(radius / plan distance) against the direction from the centre, and the plan
// distance from the eye is the other leg (core/geometry/eye_circle.h).
template <bool kOnCircle>
RAYWALK_INLINE void project_points(const float* sin_phi, const float* cos_phi, DrawnColumn column,
                                   PanoramaSize view, std::int32_t* pixel, float* inverse,
                                   float* reach_u, float* reach_v) {
  const auto width = static_cast<float>(view.width);
  const float per_turn = width / static_cast<float>(kTwoPi);
  const float per_phi = static_cast<float>(view.height) / static_cast<float>(kPi);
  const float half = 0.5f * static_cast<float>(view.height) / static_cast<float>(column.rows);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < column.rows; ++i) {
    const float w = column.inverse[i];
    const float ahead = cos_phi[i] + w * column.from_eye.ahead;
    const float aside = w * column.from_eye.aside;
    const float up = sin_phi[i] + w * column.from_eye.up;
    const float radius = w * column.radius_m;
    const float leg = ahead * ahead + aside * aside - radius * radius;
    const float plan = std::sqrt(leg > 0.0f ? leg : 0.0f);
    const float turn = fast_atan2(aside, ahead) + (kOnCircle ? fast_atan2(radius, plan) : 0.0f);
    const float length = std::sqrt(plan * plan + up * up) + 1e-30f;
    float u = column.u + turn * per_turn;
    u += u < 0.0f ? width : 0.0f;
    u -= u >= width ? width : 0.0f;
    const float v = (static_cast<float>(kHalfPi) - fast_atan2(up, plan)) * per_phi;
    const int x = u < 0.0f ? 0 : static_cast<int>(u), y = v < 0.0f ? 0 : static_cast<int>(v);
    pixel[i] = (x > view.width - 1 ? view.width - 1 : x) * view.height +
               (y > view.height - 1 ? view.height - 1 : y);
    // What is inside the circle no eye sees.
    inverse[i] = leg >= 0.0f ? w / length : kUnseen;
    reach_v[i] = half / length;
    reach_u[i] = half * cos_phi[i] / (plan + 1e-6f);
  }
}

RAYWALK_VECTOR_CLONES void project(const float* sin_phi, const float* cos_phi, DrawnColumn column,
                                   PanoramaSize view, std::int32_t* pixel, float* inverse,
                                   float* reach_u, float* reach_v) {
  if (column.radius_m == 0.0f) {
    project_points<false>(sin_phi, cos_phi, column, view, pixel, inverse, reach_u, reach_v);
  } else {
    project_points<true>(sin_phi, cos_phi, column, view, pixel, inverse, reach_u, reach_v);
  }
}

// Draws the points of a column, the nearest surface staying.
void draw(const DrawnPoints& points, PanoramaSize view, float* image) {
  const auto mark = [](float inverse, float* pixel) { *pixel = std::max(*pixel, inverse); };
  for (std::size_t i = 0; i < points.pixel.size(); ++i) {
    const float w = points.inverse[i];
    mark(w, image + points.pixel[i]);
    constexpr float kWide = 1.5f;  // less is closed afterwards
    if (w < 0.0f || (points.reach_u[i] < kWide && points.reach_v[i] < kWide)) continue;
    const int across =
        static_cast<int>(std::min(points.reach_u[i], static_cast<float>(view.width) / 16.0f));
    const int down = static_cast<int>(std::min(points.reach_v[i], 8.0f));
    const int u = points.pixel[i] / view.height, v = points.pixel[i] % view.height;
    for (int column = u - across; column <= u + across; ++column) {
      float* const pixels = image + wrapped_column(column, view.width) * view.height;
      for (int row = std::max(0, v - down); row <= std::min(view.height - 1, v + down); ++row) {
        mark(w, pixels + row);
      }
    }
  }
}

// w <- what a map holds of the points at w; negative where it does not agree.
RAYWALK_VECTOR_CLONES void refine(const float* sin_phi, const float* cos_phi, const float* drawn,
                                  int rows, ColumnLookup map, float tolerance, float* refined) {
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    const float w = drawn[i] < 0.0f ? 0.0f : drawn[i];
    const HeldPoint held = look_up_point(map, sin_phi[i], cos_phi[i], w, tolerance);
    refined[i] = drawn[i] < 0.0f ? kUnseen : held.inverse;
  }
}

}  // namespace

float surface_tolerance_of_view(int width) {
  return static_cast<float>(std::min(0.25, std::tan(radians_from_degrees(80.0)) * kTwoPi / width));
}

void DistanceView::compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m) {
  read(maps);
  opposite_ = this;
  gather({viewpoint_m});
  fill(this, size_.width / 2);
  smooth();
}

void DistanceView::compute_stereo(std::span<const MapStation> maps, const EyeCircle& circle,
                                  DistanceView* left, DistanceView* right) {
  left->read(maps);
  right->maps_ = left->maps_;
  right->map_m_ = left->map_m_;
  left->opposite_ = right;
  right->opposite_ = left;
  left->gather(circle);
  right->drawn_.swap(left->drawn_);  // one eye after the other in the same memory
  right->gather(circle.opposite());
  left->drawn_.swap(right->drawn_);
  left->fill(right, left->size_.width);
  left->smooth();
  right->smooth();
}

void DistanceView::read(std::span<const MapStation> maps) {
  maps_ = cache_.get(maps);
  map_m_.clear();
  for (const MapStation& map : maps) map_m_.push_back(map.position_m);
}

std::vector<ColumnLookup> DistanceView::lookups(double theta_rad) const {
  const Eigen::Vector3d eye_m = eye_.position_m(theta_rad);
  std::vector<ColumnLookup> lookups;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    lookups.emplace_back(*maps_[i], map_m_[i], eye_m, theta_rad);
  }
  return lookups;
}

void DistanceView::gather(const EyeCircle& circle) {
  eye_ = circle;
  size_ = {};
  for (const auto& map : maps_) {
    if (map->size.width > size_.width) size_ = map->size;
  }
  tolerance_ = surface_tolerance_of_view(size_.width);
  if (latitudes_.rows() != size_.height) latitudes_ = Latitudes(size_.height);
  const std::size_t pixels = first(size_.width);
  inverse_.resize(pixels);
  unseen_.resize(pixels);
  unseen_count_.resize(static_cast<std::size_t>(size_.width));
  drawn_.resize(pixels * maps_.size());
  parallel_for(0, static_cast<int>(maps_.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const SurfaceMap& map = *maps_[i];
      float* const image = drawn_.data() + pixels * i;
      std::fill_n(image, pixels, kUnseen);
      const Latitudes latitudes(map.size.height);
      DrawnPoints points(map.size.height);
      for (int theta = 0; theta < map.size.width; ++theta) {
        const DrawnColumn column{
            .inverse = map.inverse.data() + static_cast<std::size_t>(theta) * points.pixel.size(),
            .rows = map.size.height,
            .from_eye =
                offset_in_column(map_m_[i] - eye_.centre_m, theta_of_column(theta, map.size.width)),
            .radius_m = static_cast<float>(eye_.radius_m),
            .u = (static_cast<float>(theta) + 0.5f) * static_cast<float>(size_.width) /
                 static_cast<float>(map.size.width)};
        project(latitudes.sin_phi.data(), latitudes.cos_phi.data(), column, size_,
                points.pixel.data(), points.inverse.data(), points.reach_u.data(),
                points.reach_v.data());
        draw(points, size_, image);
      }
    }
  });
  parallel_for(0, size_.width, 32, [&](int begin, int end) { close_and_refine(begin, end); });
  double unseen = 0.0;
  for (const int count : unseen_count_) unseen += count;
  unseen_share_ = unseen / static_cast<double>(pixels);
  // Whether any map is unreliable somewhere; smooth_ then knows where.
  trust_.clear();
  unreliable_.clear();
  std::vector<TrustedMap> trusted;
  for (std::size_t i = 0; i < maps_.size(); ++i) trusted.push_back({&maps_[i]->trust, map_m_[i]});
  if (std::ranges::any_of(trusted, [](const auto& map) { return !map.trust->everywhere(); })) {
    // As the nearest map has it: of several unreliable maps the nearest surface is mostly wrong.
    filled_ = inverse_;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (drawn_[i] >= 0.0f) filled_[i] = drawn_[i];
    }
    smooth_.compute(filled_, size_, eye_, trusted);
    unreliable_.resize(static_cast<std::size_t>(size_.width));
  }
}

// Columns [begin, end): the nearest of what the maps drew, without cracks, read where it is.
void DistanceView::close_and_refine(int begin, int end) {
  constexpr int kMargin = 2;  // two steps of a 3 x 3 filter
  constexpr int kRowsAtOnce = 32;
  const auto rows = static_cast<std::size_t>(size_.height);
  cv::Mat1f drawn(end - begin + 2 * kMargin, size_.height);
  for (int u = begin - kMargin; u < end + kMargin; ++u) {
    float* const column = drawn[u - begin + kMargin];
    const std::size_t from = first(wrapped_column(u, size_.width));
    std::copy_n(drawn_.data() + from, rows, column);
    for (std::size_t i = 1; i < maps_.size(); ++i) {
      const float* const other = drawn_.data() + first(size_.width) * i + from;
      for (std::size_t v = 0; v < rows; ++v)
        column[v] = other[v] > column[v] ? other[v] : column[v];
    }
  }
  cv::morphologyEx(drawn, drawn, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  std::array<float, kRowsAtOnce> refined;
  for (int theta = begin; theta < end; ++theta) {
    const auto lookups = this->lookups(theta_of_column(theta, size_.width));
    const float* const column = drawn[theta - begin + kMargin];
    float* const inverse = inverse_.data() + first(theta);
    int unseen = 0;
    for (int from = 0; from < size_.height; from += kRowsAtOnce) {
      const int count = std::min(kRowsAtOnce, size_.height - from);
      std::fill_n(inverse + from, count, kUnseen);
      bool all_known = false;
      for (std::size_t i = 0; i < lookups.size() && !all_known; ++i) {
        refine(latitudes_.sin_phi.data() + from, latitudes_.cos_phi.data() + from, column + from,
               count, lookups[i], tolerance_, refined.data());
        all_known = true;
        for (int row = 0; row < count; ++row) {
          float& w = inverse[from + row];
          w = w < 0.0f ? refined[static_cast<std::size_t>(row)] : w;
          all_known &= w >= 0.0f;
        }
      }
      for (int row = from; row < from + count; ++row) {
        // Drawn by a map that does not agree there: as it was drawn.
        if (inverse[row] < 0.0f) inverse[row] = column[row] < 0.0f ? kUnseen : column[row];
        unseen_[first(theta) + static_cast<std::size_t>(row)] = inverse[row] < 0.0f ? 1 : 0;
        unseen += inverse[row] < 0.0f ? 1 : 0;
      }
    }
    unseen_count_[static_cast<std::size_t>(theta)] = unseen;
  }
}

void DistanceView::fill(DistanceView* opposite, int columns) {
  if (unseen_share_ + opposite->unseen_share_ == 0.0) return;
  parallel_for(0, columns, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      const int behind = (theta + size_.width / 2) % size_.width;
      if (unseen_count_[static_cast<std::size_t>(theta)] +
              opposite->unseen_count_[static_cast<std::size_t>(behind)] >
          0) {
        fill_unseen(theta, opposite);
      }
    }
  });
}

void DistanceView::fill_unseen(int theta, DistanceView* opposite) {
  const int rows = size_.height;
  float* const down = inverse_.data() + first(theta);
  float* const up = opposite->inverse_.data() + first((theta + size_.width / 2) % size_.width);
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

void DistanceView::smooth() {
  if (unseen_share_ > 0.0) {
    filled_ = inverse_;
    parallel_for(0, size_.width, 16, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        if (unseen_count_[static_cast<std::size_t>(theta)] > 0) smooth_filled(theta);
      }
    });
  }
  if (!unreliable_.empty()) smooth_unreliable();
}

void DistanceView::smooth_filled(int theta) {
  // What a row is filled from lies above or below: within this angle it is mostly one surface.
  constexpr double kReach_rad = radians_from_degrees(4.0);
  const int reach = std::max(1, static_cast<int>(std::lround(kReach_rad / kTwoPi * size_.width)));
  std::vector<float> around;
  for (int row = 0; row < size_.height; ++row) {
    const auto pixel = [&](int u) {
      return first(wrapped_column(u, size_.width)) + static_cast<std::size_t>(row);
    };
    if (unseen_[pixel(theta)] == 0) continue;
    around.clear();
    for (int u = theta - reach; u <= theta + reach; ++u) {
      if (unseen_[pixel(u)] != 0) around.push_back(filled_[pixel(u)]);
    }
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::ranges::nth_element(around, middle);
    inverse_[pixel(theta)] = *middle;
  }
}

void DistanceView::smooth_unreliable() {
  const auto rows = static_cast<std::size_t>(size_.height);
  trust_.resize(inverse_.size());
  parallel_for(0, size_.width, 16, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      const std::span trust(trust_.data() + first(theta), rows);
      std::uint8_t& unreliable = unreliable_[static_cast<std::size_t>(theta)];
      unreliable = smooth_.trust(theta, trust) ? 1 : 0;
      if (unreliable != 0) smooth_.smooth(theta, trust, {inverse_.data() + first(theta), rows});
    }
  });
}

}  // namespace raywalk
