// A station's panorama prepared for matching, and a cache of such pictures.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <memory_resource>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/matching_kernels.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Samples of a picture per map pixel, in each direction: the nearest sample is then within a
// quarter of a pixel, so matching needs no interpolation.
inline constexpr int kSamplesPerPixel = 2;

struct StationPicture {
  PanoramaSize size;                         // in samples
  std::pmr::vector<MatchingSample> samples;  // [theta][phi]
  bool all_valid = true;                     // no sample is invalid
};

// The picture of a station for maps of `map_size`. `valid` is empty or a mask of map_size, CV_8UC1:
// pixels that are 0 there, or masked in the station's own mask, become invalid. `levelled`: colours
// relative to their local means. The samples are allocated from `memory`.
StationPicture make_station_picture(
    const Room& room, StationIndex station, PanoramaSize map_size, const GainField& gains,
    const cv::Mat& valid, bool levelled = false,
    std::pmr::memory_resource* memory = std::pmr::get_default_resource());

// A least-recently-used cache of `capacity` pictures, made on demand, so that memory does not grow
// with the number of stations. Thread-safe; a picture lives as long as a caller holds it.
class PictureCache {
 public:
  // `gains` is [line][station]. The room, the gains and the pictures' memory must outlive the
  // cache.
  PictureCache(const Room& room, PanoramaSize map_size,
               const std::vector<std::vector<GainField>>& gains, cv::Mat valid,
               std::size_t capacity, bool levelled = false,
               std::pmr::memory_resource* memory = std::pmr::get_default_resource());
  std::shared_ptr<const StationPicture> get(StationIndex station);
  PanoramaSize map_size() const { return map_size_; }

 private:
  const Room& room_;
  PanoramaSize map_size_;
  const std::vector<std::vector<GainField>>& gains_;
  cv::Mat valid_;
  std::size_t capacity_;
  bool levelled_;
  std::pmr::memory_resource* memory_;
  std::mutex mutex_;
  std::map<StationIndex, std::shared_ptr<const StationPicture>> pictures_;
  std::list<StationIndex> order_;  // most recently used first
};

}  // namespace raywalk::build_lf
