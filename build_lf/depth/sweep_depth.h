// The stages of distance estimation by plane sweep and fusion. Each map is stored as soon as it is
// finished.
#pragma once

#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// The stage of the maps of find_nearest_surfaces(), and their size.
inline constexpr const char* kCoarseStage = "coarse";
PanoramaSize coarse_size(const DepthPlan& plan);

// The distance, metres, within which a quarter of what a coarse sweep is confident of lies;
// infinity if there is nothing, or it is not to be told from infinity. Nothing is stored.
double near_distance_m(const Room& room, const DepthPlan& plan,
                       const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid);

// The largest inverse distance, 1/m, to sweep: a coarse sweep at a quarter of the maps' width, down
// to a distance of a quarter of the reach (where the longest baseline is four times the distance),
// finds the distance beyond which nearly all of the scene lies. Processes one station at a time,
// with the memory of one.
double find_nearest_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                             PartialMaps* partial);

// Sweeps the station of every map, refines the maps and stores them as stage "swept".
void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                PartialMaps* partial);

// Fuses every swept map with its neighbours by their distances and colours, completes the fused
// maps (complete_map) and stores the results as kFinalStage. Where frames have masks, masked pixels
// are filled in from other stations.
void fuse_swept_maps(const Room& room, const DepthPlan& plan,
                     const std::vector<std::vector<GainField>>& gains, PartialMaps* partial);

}  // namespace raywalk::build_lf
