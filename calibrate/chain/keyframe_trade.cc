#include "calibrate/chain/keyframe_trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/files/sha256.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kStep = "trade";
constexpr const char* kFile = "trade.json";

struct SolvedTrial {
  int keyframes = 0;
  double seconds = 0.0;  // of the steps poses and grid
  bool trustworthy = false;
  FramePoses poses{};
};

SolvedTrial solve(const Calibration& calibration, double spacing_mm) {
  const fs::path directory = calibration.out() / "trade" / fmt::format("{:g}mm", spacing_mm);
  make_directories(directory);
  const CaptureSet set = calibration.panoramas();
  PosesOptions poses = calibration.poses_options();
  poses.keyframes_mm = spacing_mm;
  poses.out = directory;
  poses.work.clear();
  GridOptions grid = calibration.grid_options();
  grid.out = directory;
  PosesResult solved;
  GridResult estimated;
  const Times times = times_of([&] {
    solved = solve_poses(set, poses);
    estimated = estimate_grid(set, solved.poses, grid);
  });
  return {.keyframes = static_cast<int>(solved.keyframes.size()),
          .seconds = times.wall_s,
          .trustworthy = estimated.trustworthy,
          .poses = std::move(estimated.poses)};
}

// Differences are to the densest spacing, over all stations, after removing the mean displacement,
// which is unobservable.
ordered_json trial_json(double spacing_mm, const SolvedTrial& solved, const FramePoses& densest) {
  std::vector<Eigen::Vector3d> moved_m;
  std::vector<double> apart_mm, apart_deg;
  Eigen::Vector3d mean_m(0, 0, 0);
  for (std::size_t i = 0; i < densest.size(); ++i) {
    const auto& pose = solved.poses[i];
    if (!densest[i] || !pose) continue;
    moved_m.emplace_back(pose->position_m - densest[i]->position_m);
    mean_m += moved_m.back();
    apart_deg.push_back(degrees_from_radians(
        angle_between(pose->world_from_camera, densest[i]->world_from_camera)));
  }
  ordered_json trial{{"keyframes_mm", spacing_mm},
                     {"keyframes", solved.keyframes},
                     {"seconds", solved.seconds},
                     {"trustworthy", solved.trustworthy}};
  if (moved_m.empty()) return trial;
  mean_m /= static_cast<double>(moved_m.size());
  for (const Eigen::Vector3d& moved : moved_m) apart_mm.push_back(1000.0 * (moved - mean_m).norm());
  trial["largest_mm"] = *std::max_element(apart_mm.begin(), apart_mm.end());
  trial["largest_deg"] = *std::max_element(apart_deg.begin(), apart_deg.end());
  trial["median_mm"] = median(std::move(apart_mm));
  trial["median_deg"] = median(std::move(apart_deg));
  return trial;
}

}  // namespace

ordered_json compare_keyframes(Calibration* calibration, std::vector<double> spacings_mm) {
  std::sort(spacings_mm.begin(), spacings_mm.end());
  spacings_mm.erase(std::unique(spacings_mm.begin(), spacings_mm.end()), spacings_mm.end());
  std::string inputs = calibration->fingerprint_without_keyframes();
  for (const double spacing_mm : spacings_mm) inputs += fmt::format(" {}", spacing_mm);
  const std::string fingerprint = sha256_hex(inputs);
  if (calibration->records().done(kStep, fingerprint)) {
    return ordered_json::parse(read_file(calibration->out() / kFile));
  }
  ordered_json trials = ordered_json::array();
  FramePoses densest;
  double seconds = 0.0;
  for (const double spacing_mm : spacings_mm) {
    const SolvedTrial solved = solve(*calibration, spacing_mm);
    if (trials.empty()) densest = solved.poses;
    trials.push_back(trial_json(spacing_mm, solved, densest));
    seconds += solved.seconds;
  }
  write_file_atomically(calibration->out() / kFile, json_text(trials));
  calibration->records().note(kStep, fingerprint, seconds, {kFile});
  return trials;
}

}  // namespace raywalk::calibrate
