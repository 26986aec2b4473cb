#include "calibrate/grid/crossing_matches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calibrate/base/frame_masks.h"
#include "calibrate/grid/panorama_features.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

// Stitched panoramas blend both lenses around the seam: pixels there have no single centre of
// projection.
constexpr double kSeam_rad = radians_from_degrees(4.0);

std::optional<MatchRay> ray_of(const Eigen::Vector3d& bearing,
                               const std::optional<DualFisheyeLayout>& lenses) {
  if (!lenses) return MatchRay{Eigen::Vector3d::Zero(), bearing};
  if (std::fabs(bearing.z()) < std::sin(kSeam_rad)) return std::nullopt;
  return MatchRay{bearing.z() > 0 ? lenses->front_position_m : lenses->back_position_m, bearing};
}

cv::Mat panorama_of(const CaptureSet& set, int frame) {
  const CaptureFrame& station = set.frames[static_cast<size_t>(frame)];
  cv::Mat picture = read_panorama(station.file);
  if (picture.cols != set.frame.width || picture.rows != set.frame.height) {
    throw Error(fmt::format(
        "{} is {} x {} pixels, the other frames are {} x {}: it is of another "
        "camera or was stitched differently; replace it",
        station.file.string(), picture.cols, picture.rows, set.frame.width, set.frame.height));
  }
  return picture;
}

// The features of every frame to be matched, by frame.
std::map<int, PanoramaFeatures> features_of(const CaptureSet& set,
                                            const std::vector<CrossingMatches>& crossings,
                                            const std::optional<cv::Mat>& mask) {
  std::map<int, PanoramaFeatures> features;
  for (const CrossingMatches& crossing : crossings) {
    for (const int frame : crossing.frames_x) features.emplace(frame, PanoramaFeatures{});
    for (const int frame : crossing.frames_z) features.emplace(frame, PanoramaFeatures{});
  }
  std::vector<std::pair<int, PanoramaFeatures*>> work;
  work.reserve(features.size());
  for (auto& [frame, found] : features) work.emplace_back(frame, &found);
  const FeatureFinder finder(set.frame);
  Progress progress("features at crossings", static_cast<std::int64_t>(work.size()), "frames");
  parallel_for(0, static_cast<int>(work.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto& [frame, found] = work[static_cast<size_t>(i)];
      *found =
          finder.find(panorama_of(set, frame), joint_mask(set, frame, mask.value_or(cv::Mat())));
      progress.advance();
    }
  });
  return features;
}

// More matches of two frames add little but computing time, so an evenly spaced subset is kept.
void thin_matches(std::vector<CrossingMatch>* matches) {
  constexpr size_t kMostPerHalf = 200;
  for (const bool held_out : {false, true}) {
    const auto of_half = [&](const CrossingMatch& match) { return match.held_out == held_out; };
    const auto count =
        static_cast<size_t>(std::count_if(matches->begin(), matches->end(), of_half));
    size_t number = 0;
    std::erase_if(*matches, [&](const CrossingMatch& match) {
      if (!of_half(match)) return false;
      const size_t before = number * kMostPerHalf / std::max(count, kMostPerHalf);
      ++number;
      return before == number * kMostPerHalf / std::max(count, kMostPerHalf);
    });
  }
}

void match_frames(int frame_x, const PanoramaFeatures& features_x, int frame_z,
                  const PanoramaFeatures& features_z, const FramePoses& start,
                  const std::optional<DualFisheyeLayout>& lenses, CrossingMatches* crossing) {
  const Eigen::Matrix3d& world_from_x = start[static_cast<size_t>(frame_x)]->world_from_camera;
  const Eigen::Matrix3d& world_from_z = start[static_cast<size_t>(frame_z)]->world_from_camera;
  std::vector<CrossingMatch> matches;
  for (const FeaturePair& pair : match_features(features_x, world_from_x, features_z, world_from_z,
                                                radians_from_degrees(kMatchGate_deg))) {
    const Eigen::Vector3d& bearing_z = features_z.bearings[static_cast<size_t>(pair.b)];
    const auto ray_x = ray_of(features_x.bearings[static_cast<size_t>(pair.a)], lenses);
    const auto ray_z = ray_of(bearing_z, lenses);
    if (!ray_x || !ray_z) continue;
    matches.push_back(
        {frame_x, frame_z, *ray_x, *ray_z, in_held_out_patch(world_from_z * bearing_z)});
  }
  thin_matches(&matches);
  crossing->matches.insert(crossing->matches.end(), matches.begin(), matches.end());
}

}  // namespace

std::vector<int> nearest_frames(const CaptureSet& set, int line, PlanPoint crossing) {
  const CaptureLine& rail = set.lines[static_cast<size_t>(line)];
  const double at_m = rail.axis == LineAxis::kX ? crossing.x_m : crossing.z_m;
  const auto away_m = [&](int frame) {
    const Eigen::Vector3d& place = set.frames[static_cast<size_t>(frame)].nominal_m;
    return std::fabs((rail.axis == LineAxis::kX ? place.x() : place.z()) - at_m);
  };
  std::vector<int> frames = rail.frames;
  std::stable_sort(frames.begin(), frames.end(),
                   [&](int a, int b) { return away_m(a) < away_m(b); });
  frames.resize(std::min<size_t>(frames.size(), kCrossingStations));
  return frames;
}

bool in_held_out_patch(const Eigen::Vector3d& world_direction) {
  constexpr int kPatchesPerFace = 8;
  Eigen::Index axis = 0;
  const double largest = world_direction.cwiseAbs().maxCoeff(&axis);
  // Equal angles rather than equal lengths of the cube's face.
  const auto patch = [&](Eigen::Index other) {
    const double share = std::atan(world_direction[other % 3] / largest) / kHalfPi + 0.5;
    return static_cast<int>(std::floor(share * kPatchesPerFace));
  };
  return (patch(axis + 1) + patch(axis + 2)) % 2 == 0;
}

std::vector<CrossingMatches> find_crossing_matches(const CaptureSet& set, const FramePoses& start,
                                                   const std::optional<cv::Mat>& mask,
                                                   const std::optional<DualFisheyeLayout>& lenses) {
  std::vector<CrossingMatches> crossings;
  for (const LineCrossing& crossing : crossings_of(set)) {
    crossings.push_back({crossing,
                         nearest_frames(set, crossing.along_x, crossing.at),
                         nearest_frames(set, crossing.along_z, crossing.at),
                         {}});
  }
  const std::map<int, PanoramaFeatures> features = features_of(set, crossings, mask);
  std::int64_t pairs = 0;
  for (const CrossingMatches& crossing : crossings) {
    pairs += std::ssize(crossing.frames_x) * std::ssize(crossing.frames_z);
  }
  Progress progress("matching at crossings", pairs, "pairs");
  parallel_for(0, static_cast<int>(crossings.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      CrossingMatches& crossing = crossings[static_cast<size_t>(i)];
      for (const int x : crossing.frames_x) {
        for (const int z : crossing.frames_z) {
          match_frames(x, features.at(x), z, features.at(z), start, lenses, &crossing);
          progress.advance();
        }
      }
    }
  });
  return crossings;
}

}  // namespace raywalk::calibrate
