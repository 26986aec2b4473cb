// The distance maps of a room, reduced for comparing what stations see.
#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct SurfaceMaps {
  PanoramaSize size;                   // of all maps
  std::vector<StationIndex> stations;  // that have a map, increasing
  // The map of one of `stations`. Called on several threads.
  std::function<InverseDistanceMap(StationIndex)> read;
  // A mask for all pictures, an upright panorama of any size, CV_8UC1: 0 = invalid; may be empty.
  cv::Mat valid{};
};

// The maps in use of an opened room, which must outlive the result, reduced to at most
// kSurfaceWidth (patch_ratios.h). Known is what views use.
SurfaceMaps surface_maps_of(const Room& room);

}  // namespace raywalk::build_lf
