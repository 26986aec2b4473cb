// What single stations show and the others contradict: people and cars that moved.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A surface that other stations see at a contradicted pixel.
struct SurfaceBehind {
  int theta = 0;  // pixel of a map of Contradictions::size
  int phi = 0;
  float inverse = 0.0f;  // inverse distance, 1/m; negative: not known
};

struct ContradictedStation {
  StationIndex station;
  // [run][station, theta, first row, one past the last], pixels of the maps
  // (DistanceMaps::left_out)
  std::vector<std::int32_t> runs;
  std::vector<SurfaceBehind> behind;
};

struct Contradictions {
  PanoramaSize size;                          // in which they were looked for
  std::vector<ContradictedStation> stations;  // that have any, in order
};

// The finished map of a station of the plan.
using FinalMap = std::function<InverseDistanceMap(StationIndex)>;

// Looks for what the stations of a line contradict. Throws Interrupted.
using LineSearch = std::function<Contradictions(int line)>;

// Compares every station of a line, with or without a map, with the nearest stations that have
// maps. Their maps tell which surfaces they see in each direction; a pixel is contradicted where at
// least three of them see a surface and agree on its colour, but the station shows another, and
// no other surface that any of them sees there explains its colour. Colours are compared after
// `gains` ([line][station]), within one pixel, as distances are never exact to the pixel at edges,
// and relative to the noise of the pictures; what is clipped agrees with all that is brighter (or
// darker). Regions narrower than about five pixels of 512 around the horizon are left alone: they
// are edges and thin things that maps miss.
//
// `room`, `plan` and `gains` must outlive the result, which keeps what lines near each other share.
LineSearch contradiction_search(const Room& room, const DepthPlan& plan, const GainFields& gains,
                                FinalMap final_map);

// Replaces the distances of what moved by those of the surfaces behind it, with the lowest
// confidence that views use; confidence 0 where they are not known.
void show_behind(const Contradictions& contradictions, double tolerance_per_m,
                 InverseDistanceMap* map);

// Grey levels by which a colour must lie outside what others show.
struct GapLimits {
  float weak = 0.0f;    // belongs to a region
  float strong = 0.0f;  // makes a region
};

// The regions (CV_8UC1, 255) of `gaps`, a transposed panorama (row = theta, column = phi) of
// CV_32FC1: how far each pixel's colour lies outside what others show; 0 where they agree or are
// not known. A region is at least five pixels wide somewhere and has enough strong pixels; it is
// widened by the pixels that are mixed with it.
cv::Mat contradicted_regions(const cv::Mat& gaps, GapLimits limits);

}  // namespace raywalk::build_lf
