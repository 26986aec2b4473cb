// A station's panorama prepared for matching.
#pragma once

#include <memory_resource>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/matching_kernels.h"
#include "core/base/recently_made.h"
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

using PictureCache = RecentlyMade<StationIndex, StationPicture>;

}  // namespace raywalk::build_lf
