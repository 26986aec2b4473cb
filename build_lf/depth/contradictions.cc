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
#include "core/base/recently_made.h"
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

// What the lines of a search share.
class Search {
 public:
  Search(const Room& room, const DepthPlan& plan, const GainFields& gains, FinalMap final_map)
      : room_(room),
        plan_(plan),
        gains_(gains),
        final_map_(std::move(final_map)),
        // Neighbouring stations share most of their neighbours.
        mapped_(48, [this](StationIndex station) {
          const InverseDistanceMap map = final_map_(station);
          return evidence_of(room_, station, size_, gain_field(gains_, station), &map);
        }) {}

  Contradictions of_line(int line) {
    const auto stations = room_.grid().lines[static_cast<size_t>(line)].stations.size();
    std::vector<ContradictedStation> found(stations);
    parallel_for(0, static_cast<int>(stations), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) found[static_cast<size_t>(i)] = examine({line, i});
    });
    std::erase_if(found, [](const ContradictedStation& station) { return station.runs.empty(); });
    return {size_, std::move(found)};
  }

 private:
  ContradictedStation examine(StationIndex station) {
    const Eigen::Vector3d& position_m = room_.grid().station(station).position_m;
    std::vector<StationIndex> near;
    for (const int i : nearest_maps(plan_.maps, station, position_m, kOfOwnLine, kOfOtherLines)) {
      near.push_back(plan_.station_of(i));
    }
    const auto neighbours = mapped_.get_all(near);
    const bool has_map =
        std::ranges::find(plan_.maps, station, &SweepReference::station) != plan_.maps.end();
    const std::shared_ptr<const StationEvidence> own =
        has_map ? mapped_.get(station)
                : std::make_shared<StationEvidence>(
                      evidence_of(room_, station, size_, gain_field(gains_, station), nullptr));
    return contradicted_by(neighbours, *own, size_,
                           static_cast<float>(kAgreePx / plan_.pixels_per_inverse_m()), plan_.size);
  }

  const Room& room_;
  const DepthPlan& plan_;
  const GainFields& gains_;
  FinalMap final_map_;
  PanoramaSize size_ = size_for(plan_.size);
  RecentlyMade<StationIndex, StationEvidence> mapped_;
};

constexpr int kBorder_px = 12;  // so that regions across the seam and the poles are whole
constexpr int kMinStrongPixels = 16;
constexpr double kMinCore_px = 2.5;  // distance of the innermost pixel from the outside
constexpr int kMixed_px = 2;         // colours are compared within a pixel, and pixels are mixed

cv::Mat square_around(int around_px) {
  return cv::Mat::ones(2 * around_px + 1, 2 * around_px + 1, CV_8UC1);
}

}  // namespace

LineSearch contradiction_search(const Room& room, const DepthPlan& plan, const GainFields& gains,
                                FinalMap final_map) {
  const auto search = std::make_shared<Search>(room, plan, gains, std::move(final_map));
  return [search](int line) { return search->of_line(line); };
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
        if (behind.inverse < 0.0f) {
          map->confidence[pixel] = 0;
        } else if (std::fabs(map->inverse[pixel] - behind.inverse) > tolerance_per_m) {
          map->inverse[pixel] = behind.inverse;
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
