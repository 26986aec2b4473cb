// What a station tells about colours and surfaces, for the comparison of stations.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {

// All of one size, [theta][phi], without gaps between the columns.
struct StationEvidence {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  std::vector<float> omega;  // inverse distances, 1/m; negative: not known. Empty: no map
  cv::Mat colour;            // CV_8UC3 after the gains
  cv::Mat least, most;       // of the pixels around; 0 and 255 where dark or clipped
  cv::Mat valid;             // CV_8UC1, 0 = masked; empty: all valid

  // Of a pixel by its index (pixel_index).
  bool shows(std::size_t pixel) const { return valid.empty() || valid.ptr<uchar>()[pixel] != 0; }
  const cv::Vec3b& colour_of(std::size_t pixel) const { return colour.ptr<cv::Vec3b>()[pixel]; }
  ColourRange range(std::size_t pixel) const {
    return {least.ptr<cv::Vec3b>()[pixel], most.ptr<cv::Vec3b>()[pixel]};
  }
};

// Evidence without a map. `size` is that of the panoramas or smaller.
StationEvidence evidence_without_map(const Room& room, StationIndex station, PanoramaSize size,
                                     const GainField& gains);

// The stations with maps, made on demand; the least recently used are dropped. Can be used by
// several threads at once.
class EvidenceCache {
 public:
  // The arguments must outlive the cache.
  EvidenceCache(const Room& room, const DepthPlan& plan, PanoramaSize size,
                const std::vector<std::vector<GainField>>& gains, const FinalMap& final_map);
  // Of plan.maps[which].
  std::shared_ptr<const StationEvidence> get(int which);
  PanoramaSize size() const { return size_; }

 private:
  const Room& room_;
  const DepthPlan& plan_;
  PanoramaSize size_;
  const std::vector<std::vector<GainField>>& gains_;
  const FinalMap& final_map_;
  std::mutex mutex_;
  std::list<std::pair<int, std::shared_ptr<const StationEvidence>>> kept_;  // latest first
};

}  // namespace raywalk::build_lf
