// From swept maps to finished ones: each pixel's surface is chosen, then neighbours vote. Each map
// is stored as soon as it is finished.
#pragma once

#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/pack/work_part.h"

namespace raywalk::build_lf {

// The stage of the maps of choose_maps().
inline constexpr const char* kChosenStage = "chosen";

// The maps of the stations that say which surfaces plan.maps[which] shows: those within three
// reaches or, if they are more than kMostChoiceViews, every n-th of the plan among them, which are
// about as many. Neighbouring maps share them.
inline constexpr int kMostChoiceViews = 20;
std::vector<int> seen_from(const DepthPlan& plan, int which);

// Chooses the surfaces of the swept maps `share` of the plan (choose_surfaces) and stores the maps
// as kChosenStage. The swept maps of seen_from() must be stored. `valid`: CV_8UC1 of the maps'
// size, [phi][theta], 0 where no picture shows the scene; empty: all do. What half of the usable
// memory does not hold of the pictures lies in files of the maps' directory. Throws Error if the
// disk is full.
void choose_maps(const Room& room, const DepthPlan& plan, const GainFields& gains,
                 const cv::Mat& valid, IndexRange share, PartialMaps* partial);

// The maps whose chosen maps make the finished one of plan.maps[which], itself first. `masked`:
// Room::masked().
std::vector<int> fused_with(const DepthPlan& plan, bool masked, int which);

// Fuses the chosen maps `share` of the plan with their neighbours by their distances and colours
// and stores the results as kFinalStage. Where frames have masks, masked pixels are filled in from
// other stations. The chosen maps of fused_with() must be stored.
void fuse_chosen_maps(const Room& room, const DepthPlan& plan, const GainFields& gains,
                      IndexRange share, PartialMaps* partial);

}  // namespace raywalk::build_lf
