#include "build_lf/depth/tile_planes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

constexpr int kPlanesPerTile = 3;
// Values are taken from this far around a tile's middle, pixels at the horizon.
constexpr int kAround = 6;
// How far the tiles lie whose planes are carried to a tile, tiles.
constexpr int kCarried = 3;

// A confident value near a tile.
struct Value {
  Eigen::Vector3f beside{0, 0, 0};  // its direction less that of the tile's middle
  float inverse = 0.0f;
  float weight = 0.0f;
  bool explained = false;
};

Eigen::Vector3f middle_of(int column, int row, PanoramaSize size) {
  const auto middle = [](int tile) { return kPlaneTile * (tile + 0.5) - 0.5; };
  return direction_from_angles(angles_from_pixel({middle(column), middle(row)}, size))
      .cast<float>();
}

// The middle of the most values not yet explained that lie within `width` of each other; negative
// if fewer than `enough` are left.
float densest(const std::vector<Value>& values, float width, std::size_t enough) {
  std::vector<float> left;
  for (const Value& value : values) {
    if (!value.explained) left.push_back(value.inverse);
  }
  if (left.size() < enough) return -1.0f;
  std::sort(left.begin(), left.end());
  std::size_t most = 0, middle = 0, first = 0;
  for (std::size_t last = 0; last < left.size(); ++last) {
    while (left[last] - left[first] > width) ++first;
    if (last - first + 1 <= most) continue;
    most = last - first + 1;
    middle = (first + last) / 2;
  }
  return left[middle];
}

// inverse(u) = at_middle + slope . (u - middle)
struct LocalPlane {
  Eigen::Vector3f slope{0, 0, 0};
  float at_middle = 0.0f;

  float off(const Value& value) const {
    return std::fabs(at_middle + slope.dot(value.beside) - value.inverse);
  }
};

LocalPlane fit(const std::vector<Value>& values, float begin, float pixel_per_m) {
  // Holds the plane to the sphere at constant distance where the values do not tell a slope.
  constexpr float kRidge = 0.02f;
  LocalPlane plane{{0, 0, 0}, begin};
  // The first planes may be far off: the scale of what agrees shrinks.
  for (const float scale : {4.0f, 2.0f, 1.0f, 1.0f}) {
    Eigen::Matrix4f normal = Eigen::Matrix4f::Zero();
    Eigen::Vector4f right = Eigen::Vector4f::Zero();
    for (const Value& value : values) {
      const float off = plane.off(value) / (scale * pixel_per_m);
      const float trust = 1.0f + off * off;
      const float weight = value.weight / (trust * trust);
      Eigen::Vector4f row;
      row << value.beside, 1.0f;
      normal += weight * row * row.transpose();
      right += weight * value.inverse * row;
    }
    // The spread of the directions, squared, makes the ridge independent of their scale.
    const float spread = normal.diagonal().head<3>().sum();
    normal.diagonal().head<3>().array() += kRidge * spread + 1e-9f * normal(3, 3);
    const Eigen::Vector4f solved = normal.ldlt().solve(right);
    plane = {solved.head<3>(), solved[3]};
  }
  return plane;
}

}  // namespace

TilePlanes::TilePlanes(const InverseDistanceMap& map, double pixel_per_m)
    : size_(map.size),
      directions_(map.size),
      pixel_per_m_(static_cast<float>(pixel_per_m)),
      columns_(map.size.width / kPlaneTile),
      rows_((map.size.height + kPlaneTile - 1) / kPlaneTile),
      tiles_(tile_index(columns_, 0, rows_)) {
  parallel_for(0, columns_, 2, [&](int begin, int end) {
    for (int column = begin; column < end; ++column) {
      for (int row = 0; row < rows_; ++row) {
        tiles_[tile_index(column, row, rows_)] = fitted(map, column, row);
      }
    }
  });
}

std::span<const TilePlanes::Fitted> TilePlanes::of(int column, int row) const {
  return tiles_[tile_index((column + columns_) % columns_, row, rows_)];
}

std::vector<TilePlanes::Fitted> TilePlanes::fitted(const InverseDistanceMap& map, int column,
                                                   int row) const {
  constexpr std::uint8_t kLeastConfidence = 32;
  constexpr std::size_t kEnough = 20;
  const Eigen::Vector3f middle = middle_of(column, row, size_);
  // Around the poles columns are closer: as many of them, farther apart.
  const float cos_phi = std::sqrt(std::max(0.0f, 1.0f - middle.y() * middle.y()));
  const int aside = std::min(static_cast<int>(kAround / std::max(cos_phi, 0.05f)), size_.width / 8);
  const int step = std::max(1, aside / kAround);
  std::vector<Value> values;
  const int theta_middle = column * kPlaneTile + kPlaneTile / 2;
  const int phi_middle = row * kPlaneTile + kPlaneTile / 2;
  for (int theta = theta_middle - aside; theta < theta_middle + aside; theta += step) {
    for (int phi = std::max(0, phi_middle - kAround);
         phi < std::min(size_.height, phi_middle + kAround); ++phi) {
      const int wrapped = (theta + size_.width) % size_.width;
      const std::size_t pixel = pixel_index(wrapped, phi, size_);
      if (map.confidence[pixel] < kLeastConfidence) continue;
      values.push_back({directions_.of(wrapped, phi) - middle, map.inverse[pixel],
                        map.confidence[pixel] / 255.0f});
    }
  }
  std::vector<Fitted> planes;
  if (values.size() < kEnough) return planes;
  const std::size_t least = std::max<std::size_t>(8, values.size() / 20);
  for (int i = 0; i < kPlanesPerTile; ++i) {
    const float begin = densest(values, 3.0f * pixel_per_m_, least);
    if (begin < 0.0f) break;
    const LocalPlane plane = fit(values, begin, pixel_per_m_);
    std::size_t on_it = 0;
    for (Value& value : values) {
      const float off = plane.off(value);
      if (off < 1.5f * pixel_per_m_) ++on_it;
      value.explained = value.explained || off < 2.0f * pixel_per_m_ ||
                        std::fabs(value.inverse - begin) < 1.5f * pixel_per_m_;
    }
    if (on_it < least) continue;
    // With n / d = slope + c middle, u . (n / d) is the local plane but for terms of second order
    // if c = at_middle - slope . middle, as u . middle is nearly 1.
    planes.push_back({plane.slope + (plane.at_middle - plane.slope.dot(middle)) * middle,
                      static_cast<float>(on_it) / static_cast<float>(values.size())});
  }
  return planes;
}

std::vector<Plane> TilePlanes::around(int column, int row, std::size_t most) const {
  struct Candidate {
    float rank;
    float inverse;
    const Plane* plane;
  };
  const Eigen::Vector3f middle = middle_of(column, row, size_);
  std::vector<Candidate> candidates;
  for (int aside = -kCarried; aside <= kCarried; ++aside) {
    for (int below = -kCarried; below <= kCarried; ++below) {
      if (row + below < 0 || row + below >= rows_) continue;
      const float away = std::hypot(static_cast<float>(aside), static_cast<float>(below));
      for (const Fitted& near : of(column + aside, row + below)) {
        const float inverse = near.plane.dot(middle);
        if (inverse >= 0.0f)
          candidates.push_back({away / (0.3f + near.share), inverse, &near.plane});
      }
    }
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::rank);
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    if (kept.size() == most) break;
    const bool known = std::ranges::any_of(kept, [&](const Candidate& other) {
      return std::fabs(other.inverse - candidate.inverse) < pixel_per_m_;
    });
    if (!known) kept.push_back(candidate);
  }
  std::vector<Plane> planes;
  planes.reserve(kept.size());
  for (const Candidate& candidate : kept) planes.push_back(*candidate.plane);
  return planes;
}

}  // namespace raywalk::build_lf
