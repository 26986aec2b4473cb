// The stages of distance estimation by plane sweep and fusion. Each map is stored as soon as it is
// finished.
#pragma once

#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// The largest inverse distance, 1/m, to sweep: a coarse sweep at a quarter of the maps' width, down
// to a distance of a quarter of the reach (where the longest baseline is four times the distance),
// finds the distance beyond which nearly all of the scene lies. Processes one station at a time,
// with the memory of one.
double find_nearest_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<ColourGain>>& gains,
                             const cv::Mat& valid, PartialMaps* partial);

// Sweeps the station of every map, refines the maps and stores them as stage "swept".
void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<ColourGain>>& gains, const cv::Mat& valid,
                PartialMaps* partial);

// Fuses every swept map with its neighbours and stores the results as kFinalStage. `masked`: frames
// have masks, so masked pixels are filled in from other stations.
void fuse_swept_maps(const DepthPlan& plan, bool masked, PartialMaps* partial);

}  // namespace raywalk::build_lf
