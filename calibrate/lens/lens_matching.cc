#include "calibrate/lens/lens_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr int kDescriptorLength = 128;
// Largest ratio of the distances to the nearest and to the second nearest (Lowe 2004: 0.8).
constexpr float kRatio = 0.8F;

std::vector<int> indices_of(const LensOfView& lens) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < lens.view->features->features.size(); ++i) {
    const bool has_ray = lens.view->rays[i].direction.squaredNorm() > 0.0;
    if (lens.view->features->features[i].back == lens.back && has_ray) {
      indices.push_back(static_cast<int>(i));
    }
  }
  return indices;
}

// Similarity of descriptors of unit length, which decreases with their distance.
float similarity(const float* a, const float* b) {
  float sum = 0.0F;
  for (int i = 0; i < kDescriptorLength; ++i) sum += a[i] * b[i];
  return sum;
}

// The arc of the epipolar line on which the second camera may see a point of a ray: from the ray's
// own direction, for a point at infinity, to that of a point at the nearest distance.
class Arc {
 public:
  Arc(const ViewRay& ray, const Eigen::Vector3d& other_m, const MatchingGate& gate)
      : far_(ray.direction),
        near_((ray.origin_m + gate.nearest_m * ray.direction - other_m).normalized()),
        middle_((far_ + near_).normalized()),
        least_cosine_(std::cos(std::min(
            kPi, 0.5 * std::acos(std::clamp(far_.dot(near_), -1.0, 1.0)) + gate.tolerance_rad))),
        off_plane_(std::sin(std::min(kHalfPi, gate.tolerance_rad))) {
    const Eigen::Vector3d across = far_.cross(near_);
    const double sine = across.norm();
    if (sine > 1e-9) normal_ = across / sine;
  }

  bool allows(const Eigen::Vector3d& direction) const {
    return middle_.dot(direction) >= least_cosine_ &&
           std::fabs(normal_.dot(direction)) <= off_plane_;
  }

 private:
  Eigen::Vector3d far_;
  Eigen::Vector3d near_;
  Eigen::Vector3d middle_;
  double least_cosine_;
  double off_plane_;
  Eigen::Vector3d normal_{0, 0, 0};
};

struct Nearest {
  int index = -1;
  float similarity = -1.0F;
  float second = -1.0F;

  void offer(int candidate, float value) {
    if (value > similarity) {
      second = similarity;
      similarity = value;
      index = candidate;
    } else {
      second = std::max(second, value);
    }
  }
  // |a - b|^2 = 2 - 2 a b for unit vectors.
  bool clear() const { return index >= 0 && 1.0F - similarity < kRatio * kRatio * (1.0F - second); }
};

}  // namespace

std::vector<FeatureMatch> match_features(const LensOfView& first, const LensOfView& second,
                                         const MatchingGate& gate) {
  const std::vector<int> of_first = indices_of(first), of_second = indices_of(second);
  if (of_first.empty() || of_second.empty()) return {};
  std::vector<Nearest> forwards(of_first.size()), backwards(of_second.size());
  // Lenses of one view are so close together that the first ray's origin is used for all.
  const Eigen::Vector3d other_m =
      second.view->rays[static_cast<std::size_t>(of_second[0])].origin_m;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    const Arc arc(first.view->rays[static_cast<std::size_t>(of_first[i])], other_m, gate);
    const auto* descriptor = first.view->features->descriptors.ptr<float>(of_first[i]);
    for (std::size_t j = 0; j < of_second.size(); ++j) {
      if (!arc.allows(second.view->rays[static_cast<std::size_t>(of_second[j])].direction))
        continue;
      const float value =
          similarity(descriptor, second.view->features->descriptors.ptr<float>(of_second[j]));
      forwards[i].offer(static_cast<int>(j), value);
      backwards[j].offer(static_cast<int>(i), value);
    }
  }
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    if (!forwards[i].clear()) continue;
    const auto j = static_cast<std::size_t>(forwards[i].index);
    if (backwards[j].index == static_cast<int>(i) && backwards[j].clear()) {
      matches.push_back({of_first[i], of_second[j]});
    }
  }
  return matches;
}

}  // namespace raywalk::calibrate
