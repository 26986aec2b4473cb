#include "calibrate/lens/lens_tracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "calibrate/base/disjoint_sets.h"

namespace raywalk::calibrate {
namespace {

// Largest ratio of the distances to the nearest and to the second nearest (Lowe 2004: 0.8).
constexpr float kRatio = 0.8F;
// A still track stays within this of its mean position, twice the scatter of features.
constexpr double kStill_px = 0.6;
// A floor nearer than this many times the camera's displacement moves by far more than that.
constexpr double kLeastWay_m = 0.02;

// Features of one lens that have a direction.
std::vector<std::size_t> indices_of(const LensOfView& lens) {
  std::vector<std::size_t> indices;
  const std::vector<LensFeature>& features = lens.view.features->features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const bool has_direction = !lens.view.directions[i].isZero();
    if (features[i].back == lens.back && has_direction) indices.push_back(i);
  }
  return indices;
}

std::span<const float> descriptor_of(const LensOfView& lens, std::size_t feature) {
  const cv::Mat& all = lens.view.features->descriptors;
  return {all.ptr<float>(static_cast<int>(feature)), static_cast<std::size_t>(all.cols)};
}

// The arc of the epipolar line on which the second camera may see a point of a ray: from the ray's
// own direction, for a point at infinity, to that of a point at the nearest distance.
class Arc {
 public:
  // The ray runs in `direction` from a place `apart_m` from the second camera.
  Arc(const Eigen::Vector3d& direction, const Eigen::Vector3d& apart_m, const MatchingGate& gate)
      : off_plane_(std::sin(std::min(kHalfPi, gate.tolerance_rad))) {
    const Eigen::Vector3d nearest = (apart_m + gate.nearest_m * direction).normalized();
    const double angle_rad = std::acos(std::clamp(direction.dot(nearest), -1.0, 1.0));
    middle_ = (direction + nearest).normalized();
    least_cosine_ = std::cos(std::min(kPi, 0.5 * angle_rad + gate.tolerance_rad));
    const Eigen::Vector3d across = direction.cross(nearest);
    const double sine = across.norm();
    if (sine > 1e-9) normal_ = across / sine;
  }

  bool allows(const Eigen::Vector3d& direction) const {
    return middle_.dot(direction) >= least_cosine_ &&
           std::fabs(normal_.dot(direction)) <= off_plane_;
  }

 private:
  Eigen::Vector3d middle_{0, 0, 1};
  Eigen::Vector3d normal_{0, 0, 0};
  double least_cosine_ = 1.0;
  double off_plane_;
};

// The best two of the candidates so far, by the similarity of their descriptors.
struct Nearest {
  std::size_t index = 0;
  float similarity = -1.0F;
  float second = -1.0F;

  void offer(std::size_t candidate, float value) {
    if (value > similarity) {
      second = std::exchange(similarity, value);
      index = candidate;
    } else {
      second = std::max(second, value);
    }
  }
  // |a - b|^2 = 2 - 2 a b for unit vectors. Without a candidate it is false.
  bool is_clear() const { return 1.0F - similarity < kRatio * kRatio * (1.0F - second); }
};

bool is_consistent(const BundleTrack& track) {
  std::set<std::pair<std::size_t, bool>> views;
  std::set<std::size_t> stations;
  for (const BundleObservation& seen : track) {
    if (!views.emplace(seen.station, seen.back).second) return false;
    stations.insert(seen.station);
  }
  return track.size() >= 3 && stations.size() >= 2;
}

bool stands_still(const BundleTrack& track, std::span<const BundleStation> stations) {
  if (spans_both_lenses(track)) return false;
  const auto count = static_cast<double>(track.size());
  PixelPosition mean{};
  for (const BundleObservation& seen : track) {
    mean.u += seen.seen.u / count;
    mean.v += seen.seen.v / count;
  }
  const Eigen::Vector3d& from_m = stations[track.front().station].nominal_m;
  double squares = 0.0, way_m = 0.0;
  for (const BundleObservation& seen : track) {
    squares += std::pow(seen.seen.u - mean.u, 2) + std::pow(seen.seen.v - mean.v, 2);
    way_m = std::max(way_m, (stations[seen.station].nominal_m - from_m).norm());
  }
  return way_m >= kLeastWay_m && std::sqrt(squares / count) <= kStill_px;
}

}  // namespace

std::vector<FeatureMatch> match_features(const LensOfView& first, const LensOfView& second,
                                         const MatchingGate& gate) {
  const std::vector<std::size_t> of_first = indices_of(first), of_second = indices_of(second);
  std::vector<Nearest> forwards(of_first.size()), backwards(of_second.size());
  const Eigen::Vector3d apart_m = first.view.position_m - second.view.position_m;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    const Arc arc(first.view.directions[of_first[i]], apart_m, gate);
    const std::span<const float> descriptor = descriptor_of(first, of_first[i]);
    for (std::size_t j = 0; j < of_second.size(); ++j) {
      if (!arc.allows(second.view.directions[of_second[j]])) continue;
      const float similarity = std::inner_product(
          descriptor.begin(), descriptor.end(), descriptor_of(second, of_second[j]).begin(), 0.0F);
      forwards[i].offer(j, similarity);
      backwards[j].offer(i, similarity);
    }
  }
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    if (!forwards[i].is_clear()) continue;
    const std::size_t j = forwards[i].index;
    if (backwards[j].index == i && backwards[j].is_clear()) {
      matches.push_back({of_first[i], of_second[j]});
    }
  }
  return matches;
}

std::vector<BundleTrack> join_tracks(std::span<const LensFeatures> stations,
                                     std::span<const ViewMatches> matches) {
  std::vector<std::size_t> first{0};  // the number of each station's first feature
  for (const LensFeatures& station : stations) {
    first.push_back(first.back() + station.features.size());
  }
  DisjointSets joined(first.back());
  for (const ViewMatches& view : matches) {
    for (const FeatureMatch& match : view.matches) {
      joined.join(first[view.first] + match.first, first[view.second] + match.second);
    }
  }
  std::vector<BundleTrack> by_root(first.back());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const std::vector<LensFeature>& features = stations[s].features;
    for (std::size_t i = 0; i < features.size(); ++i) {
      by_root[joined.root(first[s] + i)].push_back({s, features[i].back, features[i].seen});
    }
  }
  std::erase_if(by_root, [](const BundleTrack& track) { return !is_consistent(track); });
  return by_root;
}

int remove_still_tracks(const DualFisheyeLayout& layout, std::span<const BundleStation> stations,
                        const Eigen::Vector3d& down, double cone_rad,
                        std::vector<BundleTrack>* tracks) {
  const Eigen::Matrix3d camera_from_back = world_from_camera(layout.back_attitude);
  const auto is_still = [&](const BundleTrack& track) {
    const BundleObservation& seen = track.front();
    const auto direction = unproject(seen.back ? layout.back : layout.front, seen.seen);
    if (!direction) return false;
    const Eigen::Vector3d in_camera = seen.back ? camera_from_back * *direction : *direction;
    return in_camera.dot(down) > std::cos(cone_rad) && stands_still(track, stations);
  };
  return static_cast<int>(std::erase_if(*tracks, is_still));
}

void thin_tracks(std::size_t most, std::vector<BundleTrack>* tracks) {
  if (tracks->size() <= most) return;
  const auto others = std::stable_partition(tracks->begin(), tracks->end(), spans_both_lenses);
  const auto both = static_cast<std::size_t>(others - tracks->begin());
  const std::size_t count = tracks->size() - both;
  const std::size_t wanted = most - std::min(most, both);
  for (std::size_t i = 0; i < wanted; ++i) {
    std::swap((*tracks)[both + i], (*tracks)[both + i * count / wanted]);
  }
  tracks->resize(most);
}

}  // namespace raywalk::calibrate
