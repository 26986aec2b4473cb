#include "build_lf/depth/contradictions.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "build_lf/depth/nearest_maps.h"
#include "build_lf/depth/station_comparison.h"
#include "core/base/parallel.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

constexpr int kLargestWidth = 512;  // regions of people are larger; four times cheaper than 1024
// The stations compared.
constexpr size_t kOfOwnLine = 4;
constexpr size_t kOfOtherLines = 8;
static_assert(kOfOwnLine + kOfOtherLines <= kMostNeighbours);
constexpr float kAgreePx = 2.0f;  // of parallax at the reach: maps agree on a surface

// The size of the maps or a half, a quarter, ... of it.
PanoramaSize size_for(PanoramaSize maps) {
  PanoramaSize size = maps;
  while (size.width > kLargestWidth && size.width % 8 == 0) {
    size = {size.width / 2, size.height / 2};
  }
  return size;
}

NearestMaps places_of(const DepthPlan& plan) {
  std::vector<MapPlace> places;
  for (const SweepReference& map : plan.maps) places.push_back({map.station, map.position_m});
  return NearestMaps(std::move(places));
}

// The regions as runs of pixels of the maps.
void add_regions(const cv::Mat& regions, const StationComparison& comparison, PanoramaSize size,
                 PanoramaSize maps, ContradictedStation* found) {
  const int step = maps.width / size.width;
  double all = 0.0;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const double solid_angle = std::sin((phi + 0.5) * kPi / size.height);
      all += solid_angle;
      if (regions.at<uchar>(theta, phi) == 0) continue;
      found->share += solid_angle;
      found->behind.push_back({theta, phi, comparison.surface_behind(theta, phi)});
      const bool continues = phi > 0 && regions.at<uchar>(theta, phi - 1) != 0;
      for (int column = 0; column < step; ++column) {
        if (!continues) {
          int end = phi + 1;
          while (end < size.height && regions.at<uchar>(theta, end) != 0) ++end;
          found->runs.insert(found->runs.end(), {theta * step + column, phi * step, end * step});
        }
      }
    }
  }
  found->share /= all;
}

// What the lines of a search share.
struct Search {
  Search(const Room& room_, const DepthPlan& plan_,
         const std::vector<std::vector<GainField>>& gains_, FinalMap final_map_)
      : room(room_), plan(plan_), gains(gains_), final_map(std::move(final_map_)) {}

  const Room& room;
  const DepthPlan& plan;
  const std::vector<std::vector<GainField>>& gains;  // [line][station]
  FinalMap final_map;
  PanoramaSize size = size_for(plan.size);
  NearestMaps nearest = places_of(plan);
  EvidenceCache cache{room, plan, size, gains, final_map};
};

ContradictedStation examine(StationIndex station, Search* shared) {
  const Search& search = *shared;
  EvidenceCache* const cache = &shared->cache;
  const auto line = static_cast<size_t>(station.line);
  const auto number = static_cast<size_t>(station.station);
  const auto& maps = search.plan.maps;
  std::vector<std::shared_ptr<const StationEvidence>> neighbours;
  const Eigen::Vector3d& position_m = search.room.grid().lines[line].stations[number].position_m;
  for (const int i : search.nearest.around(station, position_m, kOfOwnLine, kOfOtherLines)) {
    neighbours.push_back(cache->get(i));
  }
  // The maps are in the order of lines and stations.
  const auto mapped =
      std::lower_bound(maps.begin(), maps.end(), station,
                       [](const SweepReference& map, StationIndex s) { return map.station < s; });
  const std::shared_ptr<const StationEvidence> own =
      mapped != maps.end() && mapped->station == station
          ? cache->get(static_cast<int>(mapped - maps.begin()))
          : std::make_shared<StationEvidence>(evidence_without_map(
                search.room, station, search.size, search.gains[line][number]));
  const StationComparison comparison(
      *own, std::move(neighbours), search.size,
      static_cast<float>(kAgreePx / search.plan.pixels_per_omega_m()));
  ContradictedStation found{station, 0.0, {}, {}};
  add_regions(contradicted_regions(comparison.gaps(), comparison.limits()), comparison, search.size,
              search.plan.size, &found);
  return found;
}

constexpr int kBorder_px = 12;  // so that regions across the seam and the poles are whole
constexpr int kMinStrongPixels = 16;
constexpr double kMinCore_px = 2.5;  // distance of the innermost pixel from the outside
constexpr int kMixed_px = 2;         // colours are compared within a pixel, and pixels are mixed

cv::Mat square_around(int around_px) {
  return cv::Mat::ones(2 * around_px + 1, 2 * around_px + 1, CV_8UC1);
}

}  // namespace

LineSearch contradiction_search(const Room& room, const DepthPlan& plan,
                                const std::vector<std::vector<GainField>>& gains,
                                FinalMap final_map) {
  const auto search = std::make_shared<Search>(room, plan, gains, std::move(final_map));
  return [search](int line) {
    const auto stations = search->room.grid().lines[static_cast<size_t>(line)].stations.size();
    std::vector<ContradictedStation> found(stations);
    parallel_for(0, static_cast<int>(stations), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        found[static_cast<size_t>(i)] = examine({line, i}, search.get());
      }
    });
    std::erase_if(found, [](const ContradictedStation& station) { return station.runs.empty(); });
    return Contradictions{search->size, std::move(found)};
  };
}

void show_behind(const Contradictions& contradictions, double tolerance_per_m,
                 InverseDistanceMap* map) {
  const auto found =
      std::ranges::find(contradictions.stations, map->station, &ContradictedStation::station);
  if (found == contradictions.stations.end()) return;
  const int step = map->size.width / contradictions.size.width;
  for (const SurfaceBehind& behind : found->behind) {
    for (int theta = behind.theta * step; theta < (behind.theta + 1) * step; ++theta) {
      for (int phi = behind.phi * step; phi < (behind.phi + 1) * step; ++phi) {
        const size_t pixel = pixel_index(theta, phi, map->size);
        if (behind.omega < 0.0f) {
          map->confidence[pixel] = 0;
        } else if (std::fabs(map->omega[pixel] - behind.omega) > tolerance_per_m) {
          map->omega[pixel] = behind.omega;
          map->confidence[pixel] = kMinConfidence;
        }
      }
    }
  }
}

cv::Mat contradicted_regions(const cv::Mat& gaps, GapLimits limits) {
  const cv::Mat bordered = with_border(gaps, kBorder_px);
  cv::Mat weak = bordered > limits.weak;
  // Parts whose colour happens to be that of the room.
  cv::morphologyEx(weak, weak, cv::MORPH_CLOSE, square_around(1));
  cv::Mat inside;
  cv::distanceTransform(weak, inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat labels;
  const int count = cv::connectedComponents(weak, labels, 4, CV_32S);
  std::vector<int> strong(static_cast<size_t>(count));
  std::vector<float> core(static_cast<size_t>(count));
  for (int row = 0; row < labels.rows; ++row) {
    for (int column = 0; column < labels.cols; ++column) {
      const auto label = static_cast<size_t>(labels.at<int>(row, column));
      strong[label] += bordered.at<float>(row, column) > limits.strong ? 1 : 0;
      core[label] = std::max(core[label], inside.at<float>(row, column));
    }
  }
  cv::Mat regions = cv::Mat::zeros(labels.size(), CV_8UC1);
  for (int row = 0; row < labels.rows; ++row) {
    for (int column = 0; column < labels.cols; ++column) {
      const auto label = static_cast<size_t>(labels.at<int>(row, column));
      const bool kept =
          label > 0 && strong[label] >= kMinStrongPixels && core[label] >= kMinCore_px;
      regions.at<uchar>(row, column) = kept ? 255 : 0;
    }
  }
  cv::dilate(regions, regions, square_around(kMixed_px));
  return without_border(regions, kBorder_px).clone();
}

}  // namespace raywalk::build_lf
