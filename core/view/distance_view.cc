#include "core/view/distance_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

constexpr float kUnseen = -1.0f;

// The points of a column of a map in the view.
struct DrawnPoints {
  explicit DrawnPoints(int rows)
      : pixel(static_cast<std::size_t>(rows)), inverse(pixel.size()), wide(pixel.size()) {}
  std::vector<std::int32_t> pixel;
  std::vector<float> inverse;
  std::vector<std::uint8_t> wide;  // whether a point covers more than what is closed afterwards
};

constexpr float kWide = 1.5f;  // pixels from a point's middle; less is closed afterwards

// Half of a map's pixel in pixels of the view, from the map's station.
float half_size(PanoramaSize view, int map_rows) {
  return 0.5f * static_cast<float>(view.height) / static_cast<float>(map_rows);
}

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
                                   std::uint8_t* wide) {
  const auto width = static_cast<float>(view.width);
  const float per_turn = width / static_cast<float>(kTwoPi);
  const float per_phi = static_cast<float>(view.height) / static_cast<float>(kPi);
  const float half = half_size(view, column.rows);
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
    const float reach = cos_phi[i] * length > plan ? cos_phi[i] * length : plan;
    wide[i] = static_cast<std::uint8_t>(half * reach >= kWide * plan * length);
  }
}

RAYWALK_VECTOR_CLONES void project(const float* sin_phi, const float* cos_phi, DrawnColumn column,
                                   PanoramaSize view, std::int32_t* pixel, float* inverse,
                                   std::uint8_t* wide) {
  if (column.radius_m == 0.0f) {
    project_points<false>(sin_phi, cos_phi, column, view, pixel, inverse, wide);
  } else {
    project_points<true>(sin_phi, cos_phi, column, view, pixel, inverse, wide);
  }
}

// Draws the points of a column, the nearest surface staying.
void draw(const DrawnPoints& points, float* image) {
  for (std::size_t i = 0; i < points.pixel.size(); ++i) {
    float& pixel = image[points.pixel[i]];
    pixel = std::max(pixel, points.inverse[i]);
  }
}

// Draws those that cover several pixels.
void draw_wide(const DrawnPoints& points, const Latitudes& latitudes, DrawnColumn column,
               PanoramaSize view, float* image) {
  const auto next = [&](auto from) { return std::find(from, points.wide.end(), std::uint8_t{1}); };
  for (auto at = next(points.wide.begin()); at != points.wide.end(); at = next(at + 1)) {
    const auto i = static_cast<std::size_t>(at - points.wide.begin());
    if (points.inverse[i] < 0.0f) continue;
    const float half = half_size(view, column.rows), w = column.inverse[i];
    const float ahead = latitudes.cos_phi[i] + w * column.from_eye.ahead;
    const float aside = w * column.from_eye.aside, radius = w * column.radius_m;
    const float leg = ahead * ahead + aside * aside - radius * radius;
    const float plan = std::sqrt(std::max(leg, 0.0f));
    const float length = std::hypot(plan, latitudes.sin_phi[i] + w * column.from_eye.up) + 1e-30f;
    const int u = points.pixel[i] / view.height, v = points.pixel[i] % view.height;
    const auto across = static_cast<int>(std::min(half * latitudes.cos_phi[i] / (plan + 1e-6f),
                                                  static_cast<float>(view.width) / 16.0f));
    const auto down = static_cast<int>(std::min(half / length, 8.0f));
    for (int x = u - across; x <= u + across; ++x) {
      float* const pixels = image + wrapped_column(x, view.width) * view.height;
      for (int y = std::max(0, v - down); y <= std::min(view.height - 1, v + down); ++y) {
        pixels[y] = std::max(pixels[y], points.inverse[i]);
      }
    }
  }
}

// The drawn rows of a column that no map has refined yet.
struct UnrefinedRows {
  void reset(const Latitudes& latitudes, std::span<const float> column) {
    row.clear();
    for (auto* values : {&sin_phi, &cos_phi, &drawn}) values->clear();
    for (std::size_t i = 0; i < column.size(); ++i) {
      if (column[i] < 0.0f) continue;
      row.push_back(static_cast<int>(i));
      sin_phi.push_back(latitudes.sin_phi[i]);
      cos_phi.push_back(latitudes.cos_phi[i]);
      drawn.push_back(column[i]);
    }
    for (auto* values : {&part, &refined}) values->resize(row.size());
  }
  // w <- what a map holds of the points at w; takes those out that it agrees with.
  void refine(const ColumnLookup& map, float tolerance, float* inverse) {
    look_up_points(map, sin_phi.data(), cos_phi.data(), drawn.data(), static_cast<int>(row.size()),
                   tolerance, part.data(), refined.data());
    std::size_t left = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (refined[i] >= 0.0f) {
        inverse[row[i]] = refined[i];
        continue;
      }
      row[left] = row[i];
      sin_phi[left] = sin_phi[i];
      cos_phi[left] = cos_phi[i];
      drawn[left++] = drawn[i];
    }
    row.resize(left);
  }

  std::vector<int> row;
  std::vector<float> sin_phi, cos_phi, drawn, part, refined;
};

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
                points.pixel.data(), points.inverse.data(), points.wide.data());
        draw(points, image);
        draw_wide(points, latitudes, column, size_, image);
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
  UnrefinedRows unknown;
  for (int theta = begin; theta < end; ++theta) {
    const float* const column = drawn[theta - begin + kMargin];
    float* const inverse = inverse_.data() + first(theta);
    std::fill_n(inverse, rows, kUnseen);
    unknown.reset(latitudes_, {column, rows});
    for (const ColumnLookup& map : lookups(theta_of_column(theta, size_.width))) {
      unknown.refine(map, tolerance_, inverse);
      if (unknown.row.empty()) break;
    }
    // Drawn by a map that does not agree there: as it was drawn.
    for (const int row : unknown.row) inverse[row] = column[row];
    int unseen = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      unseen_[first(theta) + row] = inverse[row] < 0.0f ? 1 : 0;
      unseen += inverse[row] < 0.0f ? 1 : 0;
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
