// Ratios of the colours in which two stations show the same surfaces, by patches of both pictures.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
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

// A station's reduced picture, transposed (station_image.h).
struct SurfacePicture {
  Eigen::Vector3d position_m{0, 0, 0};
  cv::Mat colours{};  // CV_8UC3: red, green, blue
  // CV_8UC1: 255 where the colours tell the exposure, 0 where a ray of the pixel is masked, clipped
  // or black.
  cv::Mat valid{};
};

// `valid` is empty or a further mask, an upright panorama of any size, CV_8UC1: 0 = invalid.
SurfacePicture surface_picture(const Room& room, StationIndex station, PanoramaSize size,
                               const cv::Mat& valid);

// How much brighter `to` shows the surfaces of one of its patches than `from` in one of its own.
struct PatchRatio {
  int from = 0;  // patch of `from`
  int to = 0;    // patch of `to`
  std::array<float, 3>
      log_ratio{};               // natural logarithm of `to` / `from`, 8-bit levels; per channel
  std::array<float, 3> error{};  // standard error, at least 0.01
};

// Compares the surfaces of `map`, which is that of `from`, where both stations see them: a surface
// in front hides those behind, by `map` itself and by `to_map`, the map of `to` (null: it has
// none). All are of one size.
//
// The median of a patch's log ratios withstands what only some of its pixels show: wrong distances,
// edges, people.
std::vector<PatchRatio> compare_surfaces(const SurfacePicture& from, const InverseDistanceMap& map,
                                         const SurfacePicture& to,
                                         const InverseDistanceMap* to_map);

}  // namespace raywalk::build_lf
