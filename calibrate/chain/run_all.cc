#include "calibrate/chain/run_all.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibrate/chain/calibration_report.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kStep = "trade";
constexpr const char* kFile = "trade.json";

struct SolvedTrial {
  int keyframes = 0;
  double seconds = 0.0;
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
  PosesResult solved;
  const Times times = times_of([&] { solved = solve_poses(set, poses); });
  return {.keyframes = static_cast<int>(solved.keyframes.size()),
          .seconds = times.wall_s,
          .trustworthy = solved.trustworthy(),
          .poses = std::move(solved.poses)};
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

// Runs the step poses for each spacing in OUT/trade/, densest first, and writes
// OUT/trade.json, which is read instead if it has the same inputs. Returns its content, a list of
// what each spacing gives: {"keyframes_mm" (0: every station), "keyframes", "seconds",
// "trustworthy", "largest_mm", "largest_deg", "median_mm", "median_deg"}.
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

StepRun run_if_needed(Calibration* calibration, CalibrationStep step, std::ostream& out) {
  throw_if_interrupted();
  const bool reused = calibration->is_done(step);
  if (!reused) run_reported(calibration, step);
  const double seconds = calibration->seconds(step);
  out << fmt::format("{:<8}{:>7.1f} s{}", step_name(step), seconds,
                     reused ? "  (done earlier)" : "")
      << std::endl;
  return {.step = step, .seconds = seconds, .reused = reused};
}

void require_trustworthy(const Calibration& calibration, const ordered_json& document) {
  if (document.at("trustworthy").get<bool>()) return;
  const ordered_json& warnings = document.at("warnings");
  const std::string first =
      warnings.empty() ? "its own checks contradict it" : warnings.front().get<std::string>();
  throw Error(fmt::format(
      "the result is not trustworthy ({} warnings, the first: {}); outputs are kept in {}, see "
      "index.html and calibration.json there",
      warnings.size(), first, calibration.out().string()));
}

}  // namespace

void run_all(Calibration* calibration, const ChainOptions& options, std::ostream& out) {
  if (options.redo) calibration->forget(*options.redo);
  std::vector<StepRun> steps;
  const auto has = [&](CalibrationStep step) { return calibration->has(step); };
  const auto count = std::ranges::count_if(kCalibrationSteps, has);
  for (const CalibrationStep step : kCalibrationSteps) {
    if (!has(step)) continue;
    spdlog::info("step {} of {}: {}", steps.size() + 1, count, step_name(step));
    steps.push_back(run_if_needed(calibration, step, out));
  }
  ordered_json trade = ordered_json::array();
  if (!options.compare_keyframes_mm.empty()) {
    trade = compare_keyframes(calibration, options.compare_keyframes_mm);
  }
  const ordered_json document = write_calibration(*calibration, steps, trade);
  for (const StepRun& run : steps) {
    const std::string name = step_name(run.step);
    const ordered_json of_step = document.value(name, ordered_json());
    out << fmt::format("{}: {}\n", name, step_numbers(run.step, of_step));
  }
  const bool trustworthy = document.at("trustworthy").get<bool>();
  const auto next = document.at("rectify").at("next_command").get<std::string>();
  out << fmt::format("{}; see {}\n{}\n", trustworthy ? "trustworthy" : "not trustworthy",
                     escaped((calibration->out() / "index.html").string()), escaped(next));
  require_trustworthy(*calibration, document);
}

}  // namespace raywalk::calibrate
