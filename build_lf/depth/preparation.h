// What a depth run finds out before it makes maps: which frames are faulty, how near surfaces are,
// and by how much exposures differ.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/quality/frame_checks.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct Preparation {
  FrameChecks checks{};
  DepthPlan plan{};            // without the stations that show a fault
  double nearest_per_m = 0.0;  // the largest inverse distance that is swept
  GainFields gains{};          // after which colours are compared
};

// Finds all of it and keeps it in the directory of the maps. Warns of faulty frames as soon as they
// are known. Throws Error as plan_depth and the steps do; Interrupted.
Preparation prepare_depth(const Room& room, const DepthOptions& options, const cv::Mat& valid,
                          PartialMaps* partial);

// What was kept; nothing if it was not, or is damaged.
std::optional<Preparation> kept_preparation(const Room& room, const DepthOptions& options,
                                            const PartialMaps& partial);

void warn_of(const Room& room, const FrameChecks& checks);

}  // namespace raywalk::build_lf
