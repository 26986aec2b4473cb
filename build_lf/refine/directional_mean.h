// The colour that a surface shows in one direction, from samples of it in many.
//
// Matt surfaces show the same in all directions, so that the mean of all samples has the least
// noise. Gloss and mirrors change with the direction. So samples are gathered in cones around the
// direction, each twice as wide as the one before, and the mean is over the widest cone that does
// not contradict a narrower one: by over two standard errors of the latter's mean (O. Lepski, "On a
// problem of adaptive estimation in Gaussian white noise", Theory of Probability & Its Applications
// 35 (3), 1991).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>

namespace raywalk::build_lf {

class DirectionalMean {
 public:
  // A sample, 8-bit levels, of a weight above 0, as seen `angle_rad` beside the direction.
  void add(const cv::Vec3f& colour, float weight, float angle_rad) {
    std::size_t i = 0;
    for (float limit = kNarrowest; i + 1 < kCones && angle_rad > limit; limit *= 2.0f) ++i;
    Sum& ring = rings_[i];
    ring.weight += weight;
    ring.count += 1.0f;
    ring.colour += weight * colour;
    ring.squared += weight * colour.dot(colour);
  }

  bool empty() const {
    return std::ranges::none_of(rings_, [](const Sum& ring) { return ring.count > 0.0f; });
  }

  // Of samples that are not empty.
  cv::Vec3f value() const {
    Sum all;                   // the cone so far
    cv::Vec3f result, narrow;  // the mean over it; that of the narrower one compared with
    float limit = -1.0f;       // of the squared difference from `narrow`; below 0: none yet
    for (const Sum& ring : rings_) {
      if (ring.count == 0.0f) continue;
      all.weight += ring.weight;
      all.count += ring.count;
      all.colour += ring.colour;
      all.squared += ring.squared;
      const cv::Vec3f mean = all.colour * (1.0f / all.weight);
      const cv::Vec3f change = mean - narrow;
      if (limit >= 0.0f && change.dot(change) > limit) break;
      result = mean;
      if (all.count < kFewest) continue;
      const float own = kErrors * kErrors * all.variance() / all.count;
      if (limit >= 0.0f && own >= limit) continue;
      limit = own;
      narrow = mean;
    }
    return result;
  }

 private:
  static constexpr std::size_t kCones = 6;
  static constexpr float kNarrowest = 0.03f;  // rad; the widest but the last has 0.48
  static constexpr float kFewest = 3.0f;      // samples that say how much they vary
  static constexpr float kErrors = 2.0f;
  // Of few samples the variance is uncertain: as if these many more had been seen with the noise of
  // a good 8-bit photograph, of all channels.
  static constexpr float kPrior = 4.0f;
  static constexpr float kNoise = 3.0f * 3.0f * 3.0f;

  struct Sum {
    float weight = 0.0f, count = 0.0f;
    cv::Vec3f colour{0.0f, 0.0f, 0.0f};
    float squared = 0.0f;
    float variance() const {
      const cv::Vec3f mean = colour * (1.0f / weight);
      const float spread = std::max(0.0f, squared / weight - mean.dot(mean));
      return (spread * count + kNoise * kPrior) / (count - 1.0f + kPrior);
    }
  };
  std::array<Sum, kCones> rings_{};
};

}  // namespace raywalk::build_lf
