#include "build_lf/depth/map_completion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "build_lf/depth/pixel_directions.h"
#include "core/base/parallel.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

// A place to look at, relative to the pixel: its direction is ahead * pixel + east * e + north * n.
struct Offset {
  float ahead = 1.0f;
  float east = 0.0f;
  float north = 0.0f;
  float nearness = 0.0f;
};

// Rings around the pixel at geometrically growing radii: dense nearby, and far enough to cross a
// plain wall.
std::vector<Offset> offsets_of(PanoramaSize size) {
  constexpr int kPerRing = 16;
  constexpr double kFirstPx = 1.5;
  constexpr double kGrowth = 1.35;
  constexpr double kLast_rad = 0.25;
  const double pixel_rad = kTwoPi / size.width;
  std::vector<Offset> offsets;
  int ring = 0;
  for (double radius = kFirstPx * pixel_rad; radius <= kLast_rad; radius *= kGrowth, ++ring) {
    for (int i = 0; i < kPerRing; ++i) {
      const double angle = kTwoPi * (i + 0.5 * (ring % 2)) / kPerRing;
      offsets.push_back({static_cast<float>(std::cos(radius)),
                         static_cast<float>(std::sin(radius) * std::cos(angle)),
                         static_cast<float>(std::sin(radius) * std::sin(angle)),
                         static_cast<float>(kFirstPx * pixel_rad / radius)});
    }
  }
  return offsets;
}

// A confident pixel of the surroundings.
struct Witness {
  Eigen::Vector3f direction{0, 0, 1};
  float omega = 0.0f;
  float likeness = 0.0f;  // by colour and confidence, 0 to 1
  float weight = 0.0f;    // the same, less for those farther away
};

float median_of(std::vector<Witness>* witnesses) {
  std::sort(witnesses->begin(), witnesses->end(),
            [](const Witness& a, const Witness& b) { return a.omega < b.omega; });
  const float half =
      0.5f * std::accumulate(witnesses->begin(), witnesses->end(), 0.0f,
                             [](float sum, const Witness& w) { return sum + w.weight; });
  float passed = 0.0f;
  for (const Witness& witness : *witnesses) {
    passed += witness.weight;
    if (passed >= half) return witness.omega;
  }
  return witnesses->back().omega;
}

struct Fit {
  float omega = 0.0f;
  float agreeing = 0.0f;  // share of the weight, 0 to 1
};

// The plane through the witnesses, and where it lies in `direction`.
Fit fit_plane(const Eigen::Vector3f& direction, float tolerance, std::vector<Witness>* witnesses) {
  constexpr int kIterations = 4;
  // Holds the plane to the surface at constant distance where the witnesses do not tell a slope.
  constexpr float kRidge = 0.02f;
  const float median = median_of(witnesses);
  // omega(u) = median + slope . (u - direction): the slope is what is solved for.
  Eigen::Vector4f plane(0, 0, 0, median);
  const auto predicted = [&](const Witness& witness) {
    return plane.head<3>().dot(witness.direction - direction) + plane[3];
  };
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    // The first planes may be far off: the scale of what agrees shrinks to the tolerance.
    const float scale = tolerance * static_cast<float>(1 << (kIterations - 1 - iteration));
    Eigen::Matrix4f normal = Eigen::Matrix4f::Zero();
    Eigen::Vector4f right = Eigen::Vector4f::Zero();
    float total = 0.0f;
    for (const Witness& witness : *witnesses) {
      const float off = (predicted(witness) - witness.omega) / scale;
      const float trust = 1.0f + off * off;
      const float weight = witness.weight / (trust * trust);
      Eigen::Vector4f row;
      row << witness.direction - direction, 1.0f;
      normal += weight * row * row.transpose();
      right += weight * witness.omega * row;
      total += weight;
    }
    if (total <= 0.0f) break;
    // The spread of the directions, squared, makes the ridge independent of their scale.
    const float spread = normal.diagonal().head<3>().sum();
    normal.diagonal().head<3>().array() += kRidge * spread + 1e-9f * total;
    plane = normal.ldlt().solve(right);
  }
  Fit fit{plane[3], 0.0f};
  float total = 0.0f;
  float lowest = witnesses->back().omega, highest = witnesses->front().omega;
  for (const Witness& witness : *witnesses) {
    total += witness.weight;
    if (std::fabs(predicted(witness) - witness.omega) > 2.0f * tolerance) continue;
    fit.agreeing += witness.weight;
    lowest = std::min(lowest, witness.omega);
    highest = std::max(highest, witness.omega);
  }
  fit.agreeing /= total;
  // Beyond what its witnesses show a plane is a guess.
  if (fit.agreeing > 0.0f) {
    const float margin = 0.5f * (highest - lowest) + tolerance;
    fit.omega = std::clamp(fit.omega, std::max(0.0f, lowest - margin), highest + margin);
  }
  return fit;
}

// Whether witnesses lie around a direction rather than on one side of it, where a plane would be
// continued beyond what they show: at the outline of a thing, a slope that is a little off moves
// the outline. The mean of the unit vectors towards the witnesses has length 0 if they lie all
// around, and 2 / pi = 0.64 if they fill one half. Near and far ones count alike, so that the rim
// of a small gap in a wall is not taken for an outline.
bool surround(const Eigen::Vector3f& direction, const std::vector<Witness>& witnesses) {
  constexpr float kMaxLean = 0.3f;
  Eigen::Vector3f lean = Eigen::Vector3f::Zero();
  float total = 0.0f;
  for (const Witness& witness : witnesses) {
    const Eigen::Vector3f towards = witness.direction - direction;
    lean += witness.likeness / std::max(towards.norm(), 1e-6f) * towards;
    total += witness.likeness;
  }
  return lean.norm() <= kMaxLean * total;
}

class Completion {
 public:
  Completion(const cv::Mat& colours, const cv::Mat& valid, double tolerance_per_m,
             const InverseDistanceMap& map)
      : colours_(colours),
        valid_(valid),
        tolerance_(static_cast<float>(tolerance_per_m)),
        map_(map),
        directions_(map.size),
        offsets_(offsets_of(map.size)) {}

  // Completes a pixel if its surroundings allow it.
  void complete(int theta, int phi, float* omega, std::uint8_t* confidence) const {
    if (!shows_scene(theta, phi)) return;
    std::vector<Witness> witnesses = witnesses_of(theta, phi);
    // Enough of the places looked at, by weight, must be confident and of like colour.
    constexpr float kEnough = 1.0f;
    constexpr float kPlenty = 8.0f;
    float weight = 0.0f;
    for (const Witness& witness : witnesses) weight += witness.weight;
    if (witnesses.size() < 6 || weight < kEnough) return;
    const Eigen::Vector3f direction = directions_.of(theta, phi);
    const Fit fit = fit_plane(direction, tolerance_, &witnesses);
    constexpr float kLeastAgreement = 0.4f;
    if (fit.agreeing < kLeastAgreement) return;
    *omega = std::max(0.0f, fit.omega);
    if (!surround(direction, witnesses)) return;
    // Below half, more of what is completed is wrong than right, which kMinConfidence promises not
    // to happen.
    constexpr float kLeastSure = 0.5f;
    const float sure = fit.agreeing * std::min(1.0f, weight / kPlenty);
    if (sure < kLeastSure) return;
    const float share = (sure - kLeastSure) / (1.0f - kLeastSure);
    *confidence = static_cast<std::uint8_t>(kMinConfidence + share * (127.0f - kMinConfidence));
  }

 private:
  bool shows_scene(int theta, int phi) const {
    return valid_.empty() || valid_.at<std::uint8_t>(theta, phi) != 0;
  }

  std::vector<Witness> witnesses_of(int theta, int phi) const {
    constexpr float kLikeLevels = 12.0f;
    const cv::Vec3b& own = colours_.at<cv::Vec3b>(theta, phi);
    const Eigen::Vector3f ahead = directions_.of(theta, phi);
    const Eigen::Vector3f east = directions_.east(theta);
    const Eigen::Vector3f north = ahead.cross(east);
    std::vector<Witness> witnesses;
    for (const Offset& offset : offsets_) {
      const size_t pixel =
          pixel_of(offset.ahead * ahead + offset.east * east + offset.north * north, map_.size);
      const auto column = static_cast<int>(pixel / static_cast<size_t>(map_.size.height));
      const auto row = static_cast<int>(pixel % static_cast<size_t>(map_.size.height));
      if (map_.confidence[pixel] < kMinConfidence || !shows_scene(column, row)) continue;
      const cv::Vec3b& there = colours_.at<cv::Vec3b>(column, row);
      float difference = 0.0f;
      for (int c = 0; c < 3; ++c) difference += std::fabs(float(own[c]) - float(there[c]));
      const float unlike = difference / (3.0f * kLikeLevels);
      const float like = std::exp(-unlike * unlike);
      constexpr float kUnlike = 0.01f;
      if (like < kUnlike) continue;
      const float likeness = like * map_.confidence[pixel] / 255.0f;
      witnesses.push_back({directions_.of(column, row), map_.omega[pixel], likeness,
                           likeness * std::sqrt(offset.nearness)});
    }
    return witnesses;
  }

  const cv::Mat& colours_;
  const cv::Mat& valid_;
  float tolerance_;
  const InverseDistanceMap& map_;
  PixelDirections directions_;
  std::vector<Offset> offsets_;
};

}  // namespace

void complete_map(const cv::Mat& colours, const cv::Mat& valid, double tolerance_per_m,
                  InverseDistanceMap* map) {
  const InverseDistanceMap before = *map;
  const Completion completion(colours, valid, tolerance_per_m, before);
  parallel_for(0, map->size.width, 8, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      for (int phi = 0; phi < map->size.height; ++phi) {
        const size_t pixel = pixel_index(theta, phi, map->size);
        if (before.confidence[pixel] >= kMinConfidence) continue;
        completion.complete(theta, phi, &map->omega[pixel], &map->confidence[pixel]);
      }
    }
  });
}

}  // namespace raywalk::build_lf
