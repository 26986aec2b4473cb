// Ratios of the colours in which two stations show the same surfaces, by patches of both pictures.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/exposure/surface_maps.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A panorama is divided into kPatchesTheta x kPatchesPhi equal patches of 11 degrees: small enough
// for the picture of one lens and for a cloud, large enough that surfaces of many colours lie in
// each. Patches are numbered as the rays are stored, theta * kPatchesPhi + phi.
inline constexpr int kPatchesTheta = 32;
inline constexpr int kPatchesPhi = 16;
inline constexpr int kPatches = kPatchesTheta * kPatchesPhi;

// Pictures are compared at this width, or the room's or its maps' if that is smaller.
inline constexpr int kSurfaceWidth = 256;

// What a station shows at the size of the maps, transposed (station_image.h).
struct StationSurfaces {
  cv::Mat colours{};  // CV_8UC3: red, green, blue
  // CV_8UC1: 255 where the colours tell the exposure, 0 where a ray of the pixel is masked, clipped
  // or black.
  cv::Mat valid{};
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<InverseDistanceMap> map{};
};
StationSurfaces station_surfaces(const Room& room, StationIndex station, const SurfaceMaps& maps);

// How much brighter one station shows the surfaces of one of its patches than another in one of its
// own. Patches are numbered through all stations: station * kPatches + patch.
struct PatchRatio {
  int from = 0;
  int to = 0;
  std::array<float, 3> log_ratio{};  // natural logarithm of `to` / `from`, 8-bit levels
  std::array<float, 3> error{};      // standard error, at least 0.01
};

// Compares the surfaces of the map of `from`, where both stations see them: a surface in front
// hides those behind, by that map itself and by that of `to`, if it has one. The patches are
// numbered within their stations.
//
// The median of a patch's log ratios withstands what only some of its pixels show: wrong distances,
// edges, people.
std::vector<PatchRatio> compare_surfaces(const StationSurfaces& from, const StationSurfaces& to);

}  // namespace raywalk::build_lf
