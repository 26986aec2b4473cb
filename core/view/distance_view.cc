#include "core/view/distance_view.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

constexpr float kUnseen = -1.0f;

// Rows of a column to look up in one map after the other.
class DrawnRows {
 public:
  // w <- what the first of the maps that agrees with the points at w holds of them; else `drawn`.
  void refine(std::span<const ColumnLookup> maps, const Latitudes& latitudes,
              std::span<const float> drawn, float tolerance, float* inverse) {
    const std::size_t rows = drawn.size();
    for (auto* values : {&sin_phi_, &cos_phi_, &drawn_, &part_, &refined_}) values->resize(rows);
    row_.resize(rows);
    // Nearly all are of the first map.
    look_up_points(maps[0], latitudes.sin_phi.data(), latitudes.cos_phi.data(), drawn.data(),
                   static_cast<int>(rows), tolerance, part_.data(), inverse);
    std::size_t left = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      row_[left] = row;
      sin_phi_[left] = latitudes.sin_phi[row];
      cos_phi_[left] = latitudes.cos_phi[row];
      drawn_[left] = drawn[row];
      left += drawn[row] >= 0.0f && inverse[row] < 0.0f ? 1 : 0;
    }
    for (const ColumnLookup& map : maps.subspan(1))
      left = look_up_left(map, left, tolerance, inverse);
    for (std::size_t i = 0; i < left; ++i) inverse[row_[i]] = drawn_[i];
  }

 private:
  // Looks the first `count` rows up, and keeps those that the map does not agree with.
  std::size_t look_up_left(const ColumnLookup& map, std::size_t count, float tolerance,
                           float* inverse) {
    look_up_points(map, sin_phi_.data(), cos_phi_.data(), drawn_.data(), static_cast<int>(count),
                   tolerance, part_.data(), refined_.data());
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (refined_[i] >= 0.0f) inverse[row_[i]] = refined_[i];
      row_[left] = row_[i];
      sin_phi_[left] = sin_phi_[i];
      cos_phi_[left] = cos_phi_[i];
      drawn_[left] = drawn_[i];
      left += refined_[i] < 0.0f ? 1 : 0;
    }
    return left;
  }

  std::vector<std::size_t> row_;
  std::vector<float> sin_phi_, cos_phi_, drawn_, part_, refined_;
};

// Unseen rows of a column take the farther of the surfaces above and below; all of them unseen,
// everything is infinitely far. Returns how many there were.
int fill_unseen(std::span<float> inverse) {
  int unseen = 0;
  auto before = inverse.end();  // the last row that was seen
  for (auto row = inverse.begin(); row != inverse.end();) {
    const auto next = std::find_if(row, inverse.end(), [](float w) { return w >= 0.0f; });
    float fill = next == inverse.end() ? 0.0f : *next;
    if (before != inverse.end()) fill = next == inverse.end() ? *before : std::min(*before, *next);
    std::fill(row, next, fill);
    unseen += static_cast<int>(next - row);
    before = next;
    row = next == inverse.end() ? next : next + 1;
  }
  return unseen;
}

}  // namespace

void DistanceView::compute(std::span<const MapStation> maps, const Eigen::Vector3d& viewpoint_m) {
  begin(maps, {viewpoint_m});
  gather();
}

void DistanceView::begin_stereo(std::span<const MapStation> maps, const EyeCircle& circle,
                                DistanceView* left, DistanceView* right) {
  left->begin(maps, circle);
  right->begin(maps, circle.opposite());
  left->opposite_ = right;
  right->opposite_ = left;
}

void DistanceView::begin(std::span<const MapStation> maps, const EyeCircle& circle) {
  stations_.assign(maps.begin(), maps.end());
  opposite_ = this;
  eye_ = circle;
  size_ = {};
  for (const MapStation& map : stations_) {
    const PanoramaSize size = room_.distances(map.line).size();
    if (size.width > size_.width) size_ = size;
  }
  tolerance_ = surface_tolerance_of(size_.width);
  if (latitudes_.rows() != size_.height) latitudes_ = Latitudes(size_.height);
  trust_ = trusts_.get(stations_);
  unreliable_ = !std::ranges::all_of(trust_, [](const auto& map) { return map->everywhere(); });
}

std::vector<ColumnLookup> DistanceView::lookups(double theta_rad) const {
  const Eigen::Vector3d eye_m = eye_.position_m(theta_rad);
  std::vector<ColumnLookup> lookups;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    lookups.emplace_back(*maps_[i], stations_[i].position_m, eye_m, theta_rad);
  }
  return lookups;
}

void DistanceView::gather() {
  maps_ = cache_.get(stations_);
  const std::size_t pixels = first(size_.width);
  inverse_.resize(pixels);
  drawn_.resize(pixels * maps_.size());
  parallel_for(0, static_cast<int>(maps_.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      float* const image = drawn_.data() + pixels * i;
      std::fill_n(image, pixels, kUnseen);
      maps_[i]->points.draw(stations_[i].position_m, eye_, size_, image);
    }
  });
  parallel_for(0, size_.width, 32, [&](int begin, int end) { close_and_refine(begin, end); });
  if (unreliable_) find_smooth(inverse_, std::span(drawn_).first(pixels));
  std::atomic<int> unseen = 0;
  parallel_for(0, size_.width, 32, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      const std::span column(inverse_.data() + first(theta),
                             static_cast<std::size_t>(size_.height));
      unseen += fill_unseen(column);
      if (unreliable_) smooth_.smooth(theta, column);
    }
  });
  unseen_share_ = unseen / static_cast<double>(pixels);
}

const SmoothDistances& DistanceView::find_smooth(std::vector<float> seen,
                                                 std::span<const float> nearest) {
  // As the nearest map has it: of several unreliable maps the nearest surface is mostly wrong.
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (nearest[i] >= 0.0f) seen[i] = nearest[i];
  }
  std::vector<TrustedMap> trusted;
  for (std::size_t i = 0; i < trust_.size(); ++i) {
    trusted.push_back({trust_[i].get(), stations_[i].position_m});
  }
  smooth_.compute(seen, size_, eye_, trusted);
  return smooth_;
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
  DrawnRows refined;
  for (int theta = begin; theta < end; ++theta) {
    float* const inverse = inverse_.data() + first(theta);
    refined.refine(lookups(theta_of_column(theta, size_.width)), latitudes_,
                   {drawn[theta - begin + kMargin], rows}, tolerance_, inverse);
  }
}

}  // namespace raywalk
