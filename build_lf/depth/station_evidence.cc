#include "build_lf/depth/station_evidence.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "build_lf/depth/station_image.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

constexpr std::size_t kKept = 48;  // neighbouring stations share most of their neighbours

cv::Mat without_border_of(void (*filter)(const cv::Mat&, cv::Mat*), const cv::Mat& image) {
  cv::Mat filtered;
  filter(with_border(image, 1), &filtered);
  return without_border(filtered, 1).clone();
}

void least_around(const cv::Mat& image, cv::Mat* least) {
  cv::erode(image, *least, cv::Mat::ones(3, 3, CV_8UC1));
}
void most_around(const cv::Mat& image, cv::Mat* most) {
  cv::dilate(image, *most, cv::Mat::ones(3, 3, CV_8UC1));
}

}  // namespace

StationEvidence evidence_without_map(const Room& room, StationIndex station, PanoramaSize size,
                                     const GainField& gains) {
  StationEvidence evidence;
  evidence.station = station;
  evidence.position_m = room.grid()
                            .lines[static_cast<size_t>(station.line)]
                            .stations[static_cast<size_t>(station.station)]
                            .position_m;
  const StationColours colours = station_colours(room, station, size, gains);
  evidence.colour = colours.shown;
  evidence.least = without_border_of(least_around, colours.least);
  evidence.most = without_border_of(most_around, colours.most);
  evidence.valid = station_validity(room, station, size, 2);
  return evidence;
}

EvidenceCache::EvidenceCache(const Room& room, const DepthPlan& plan, PanoramaSize size,
                             const std::vector<std::vector<GainField>>& gains,
                             const FinalMap& final_map)
    : room_(room), plan_(plan), size_(size), gains_(gains), final_map_(final_map) {}

std::shared_ptr<const StationEvidence> EvidenceCache::get(int which) {
  {
    const std::lock_guard lock(mutex_);
    const auto known =
        std::ranges::find(kept_, which, [](const auto& entry) { return entry.first; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return known->second;
    }
  }
  const SweepReference& reference = plan_.maps[static_cast<size_t>(which)];
  const StationIndex station = reference.station;
  auto evidence = std::make_shared<StationEvidence>(evidence_without_map(
      room_, station, size_,
      gains_[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)]));
  const InverseDistanceMap map = final_map_(reference);
  const int step = map.size.width / size_.width;
  for (int theta = 0; theta < size_.width; ++theta) {
    for (int phi = 0; phi < size_.height; ++phi) {
      const size_t pixel = pixel_index(theta * step + step / 2, phi * step + step / 2, map.size);
      evidence->omega.push_back(map.confidence[pixel] < kMinConfidence ? -1.0f : map.omega[pixel]);
    }
  }
  const std::lock_guard lock(mutex_);
  if (kept_.size() == kKept) kept_.pop_back();
  kept_.emplace_front(which, evidence);
  return evidence;
}

}  // namespace raywalk::build_lf
