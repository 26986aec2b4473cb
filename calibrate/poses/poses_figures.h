// Figures of solved poses per line and crossing, reasons for missing poses, warnings, and the
// report of them as JSON.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/seen_points.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// One for each line that has keyframes, by the poses of `result`.
std::vector<LinePoses> line_figures(const CaptureSet& set, const PosesResult& result,
                                    const FramePoses& start);

// For each crossing, the number of points seen from both lines by stations within half a cell.
std::vector<CrossingPoints> crossing_figures(const CaptureSet& set,
                                             std::span<const LineCrossing> crossings,
                                             const SeenPoints& inliers);

// Features, matches and motions of the pictures before the bundle adjustment.
struct MatchSummary {
  std::map<std::size_t, int> features{};  // by keyframe
  std::map<std::size_t, int> matches{};   // verified, with all other frames, by keyframe
  std::vector<RailMotion> motions{};      // by line
};

// Why a keyframe has no pose.
std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, std::size_t frame);

// Warnings by the figures of `result`: poses that are missing or not as planned.
std::vector<std::string> pose_warnings(const CaptureSet& set,
                                       std::span<const LineCrossing> crossings,
                                       const MatchSummary& summary, const PosesResult& result);

// Writes poses-report.json into `out`. Throws Error if it cannot be written.
void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const PosesResult& result);

}  // namespace raywalk::calibrate
