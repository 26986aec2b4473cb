#include "calibrate/lens/feature_tracks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calibrate/base/disjoint_sets.h"

namespace raywalk::calibrate {
namespace {

bool is_consistent(const BundleTrack& track) {
  std::set<std::pair<int, bool>> views;
  std::set<int> stations;
  for (const BundleObservation& seen : track) {
    if (!views.emplace(seen.station, seen.back).second) return false;
    stations.insert(seen.station);
  }
  return track.size() >= 3 && stations.size() >= 2;
}

bool spans_both_lenses(const BundleTrack& track) {
  return std::any_of(track.begin(), track.end(), [&](const BundleObservation& seen) {
    return seen.back != track.front().back;
  });
}

// A still track stays within this of its mean position, twice the scatter of features.
constexpr double kStill_px = 0.6;
// A floor nearer than this many times the camera's displacement moves by far more than that.
constexpr double kLeastWay_m = 0.02;

bool stands_still(const BundleTrack& track, std::span<const Eigen::Vector3d> nominal_m) {
  if (spans_both_lenses(track)) return false;
  PixelPosition mean{};
  for (const BundleObservation& seen : track) {
    mean.u += seen.seen.u / static_cast<double>(track.size());
    mean.v += seen.seen.v / static_cast<double>(track.size());
  }
  double squares = 0.0, way_m = 0.0;
  for (const BundleObservation& seen : track) {
    squares += std::pow(seen.seen.u - mean.u, 2) + std::pow(seen.seen.v - mean.v, 2);
    way_m = std::max(way_m, (nominal_m[static_cast<std::size_t>(seen.station)] -
                             nominal_m[static_cast<std::size_t>(track.front().station)])
                                .norm());
  }
  return way_m >= kLeastWay_m &&
         std::sqrt(squares / static_cast<double>(track.size())) <= kStill_px;
}

}  // namespace

std::vector<BundleTrack> join_tracks(std::span<const LensFeatures> stations,
                                     std::span<const ViewMatches> matches) {
  std::vector<int> first{0};  // the number of each station's first feature
  for (const LensFeatures& station : stations) {
    first.push_back(first.back() + static_cast<int>(station.features.size()));
  }
  DisjointSets joined(first.back());
  const auto number_of = [&](int station, int feature) {
    return first[static_cast<std::size_t>(station)] + feature;
  };
  for (const ViewMatches& view : matches) {
    for (const FeatureMatch& match : view.matches) {
      joined.join(number_of(view.first, match.first), number_of(view.second, match.second));
    }
  }
  std::vector<BundleTrack> by_root(static_cast<std::size_t>(first.back()));
  for (int s = 0; s < static_cast<int>(stations.size()); ++s) {
    const std::vector<LensFeature>& features = stations[static_cast<std::size_t>(s)].features;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const int root = joined.root(number_of(s, static_cast<int>(i)));
      by_root[static_cast<std::size_t>(root)].push_back({s, features[i].back, features[i].seen});
    }
  }
  std::erase_if(by_root, [](const BundleTrack& track) { return !is_consistent(track); });
  return by_root;
}

int remove_still_tracks(const DualFisheyeLayout& layout, std::span<const Eigen::Vector3d> nominal_m,
                        const Eigen::Vector3d& down, double cone_rad,
                        std::vector<BundleTrack>* tracks) {
  const Eigen::Matrix3d camera_from_back = world_from_camera(layout.back_attitude);
  const auto is_still = [&](const BundleTrack& track) {
    const BundleObservation& seen = track.front();
    const auto direction = unproject(seen.back ? layout.back : layout.front, seen.seen);
    if (!direction) return false;
    const Eigen::Vector3d in_camera = seen.back ? camera_from_back * *direction : *direction;
    return in_camera.dot(down) > std::cos(cone_rad) && stands_still(track, nominal_m);
  };
  return static_cast<int>(std::erase_if(*tracks, is_still));
}

void thin_tracks(std::size_t most, std::vector<BundleTrack>* tracks) {
  if (tracks->size() <= most) return;
  const auto others = std::stable_partition(tracks->begin(), tracks->end(), spans_both_lenses);
  const auto both = static_cast<std::size_t>(others - tracks->begin());
  const std::size_t count = tracks->size() - both;
  const std::size_t wanted = std::min(count, most - std::min(most, both));
  std::vector<BundleTrack> kept(tracks->begin(), others);
  for (std::size_t i = 0; i < wanted; ++i) {
    kept.push_back(std::move((*tracks)[both + i * count / wanted]));
  }
  if (kept.size() > most) kept.resize(most);
  *tracks = std::move(kept);
}

}  // namespace raywalk::calibrate
