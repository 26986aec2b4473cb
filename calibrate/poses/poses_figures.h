// Figures of solved poses per line and intersection, reasons for missing poses, and warnings.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// One for each line that has keyframes, by the poses of `result`.
std::vector<LinePoses> line_figures(const CaptureSet& set, const PosesResult& result,
                                    const FramePoses& start);

// Fills in correction_mm and correction_deg.
void set_correction(const CaptureSet& set, const FramePoses& planned, const FramePoses& solved,
                    MeasuredIntersection* intersection);

// Features, matches and motions of the pictures before the bundle adjustment.
struct MatchSummary {
  std::map<std::size_t, int> features{};  // by keyframe
  std::map<std::size_t, int> matches{};   // verified, with all other frames, by keyframe
  std::vector<LineMotion> motions{};      // by line
};

// Why a keyframe has no pose.
std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, std::size_t frame);

// Adds warnings and notes by the figures of `result`.
void add_warnings(const CaptureSet& set, PosesResult* result);

}  // namespace raywalk::calibrate
