// Distances by plane sweep and fusion: the stages of a run, each map kept as soon as it is made.
#pragma once

#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// The inverse distance, 1/m, up to which maps have to look: a sweep at a quarter of the maps' width
// looks as near as a quarter of the reach, where the parallax at the longest baseline is four times
// the distance, and finds where nearly all of the scene begins. Stations are looked at one by one;
// memory is that of one.
double find_nearest_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<ColourGain>>& gains,
                             const cv::Mat& valid, PartialMaps* partial);

// Sweeps every map's station, refines what was found and keeps the maps as "swept".
void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<ColourGain>>& gains, const cv::Mat& valid,
                PartialMaps* partial);

// Fuses every swept map with those around it and keeps the results as "final". `masked`: whether
// frames have masks, so that what is below some stations is to be learned from others.
void fuse_swept_maps(const DepthPlan& plan, bool masked, PartialMaps* partial);

}  // namespace raywalk::build_lf
