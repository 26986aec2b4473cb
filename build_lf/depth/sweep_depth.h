// Distance maps by plane sweep. Each map is stored as soon as it is finished.
#pragma once

#include <limits>
#include <opencv2/core/mat.hpp>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/pack/work_part.h"
#include "core/room/gain_fields.h"

namespace raywalk::build_lf {

// The stage of the maps of sweep_maps().
inline constexpr const char* kSweptStage = "swept";
// The size of the maps of sweep_coarse_maps().
PanoramaSize coarse_size(const DepthPlan& plan);

// A coarse sweep of the plan's maps, at a quarter of their width or 128 pixels, which are stored:
// what it is confident of, as far as is looked for, down to a distance of a quarter of the reach,
// where the longest baseline is four times the distance. It compares colours with those around
// them, as exposures need not agree yet. Processes one station at a time, with the memory of one
// and of the pictures around it; what half of the usable memory does not hold lies in files of the
// maps' directory. Throws Error if the disk is full.
struct NearSurfaces {
  // The distance, metres, within which a quarter of that lies; infinity if there is nothing, or it
  // is not to be told from infinity.
  double near_m = std::numeric_limits<double>::infinity();
  // The largest inverse distance, 1/m, to sweep, beyond which nearly nothing of the scene lies.
  double nearest_per_m = 0.0;
};
NearSurfaces sweep_coarse_maps(const Room& room, const DepthPlan& plan, const cv::Mat& valid,
                               const char* stage, PartialMaps* partial);

// Sweeps the stations of the maps `share` of the plan and stores the maps as kSweptStage. Memory
// and errors are as for the coarse maps.
void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m, const GainFields& gains,
                const cv::Mat& valid, IndexRange share, PartialMaps* partial);

}  // namespace raywalk::build_lf
