#include "calibrate/poses/solve_poses.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/matching_faces.h"
#include "calibrate/poses/pose_accuracy.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/seen_points.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/fingerprint.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastFaceOption_px = 64;
constexpr int kMostFaceOption_px = 4096;
// A scene point has to be seen from so many frames: with two, one direction is not checked.
constexpr std::size_t kLeastFrames = 3;
// From wide, as the nominal poses are degrees off, to the accuracy of the features.
constexpr std::array kRounds{TriangulationRound{6.0, 25.0}, TriangulationRound{2.0, 6.0},
                             TriangulationRound{1.0, 1.5}};
// Scene points per panorama in the adjustments before the last one, and in the last one.
constexpr int kPointsOnTheWay = 300;
constexpr int kMostPointsAtLast = 1500;
constexpr int kLeastPointsAtLast = 100;
// Observations in the last adjustment, which takes about 600 bytes for each: panoramas of a very
// large grid keep fewer of their points.
constexpr double kObservationsAtLast = 8e6;
// Sigmas of the prior at a round's initial poses, in cells and radians: far beyond the errors of
// placing a rail, and thousands of times the uncertainty by the pictures.
constexpr double kAnchorCells = 0.1;
constexpr double kAnchor_rad = 0.1;

void require_valid(const CaptureSet& panoramas, const PosesOptions& options) {
  if (panoramas.layout != FrameLayout::kPanorama) {
    throw Error(panoramas.source.string() +
                ": its frames are not panoramas; run raywalk-calibrate stitch first");
  }
  if (!options.start.empty() && options.start.size() != panoramas.frames.size()) {
    throw UsageError(fmt::format("there are {} poses to start from, but {} stations",
                                 options.start.size(), panoramas.frames.size()));
  }
  if (!(options.keyframes_mm >= 0.0)) {
    throw UsageError(
        fmt::format("the distance of keyframes is {} mm; give 0 for every station, or more",
                    options.keyframes_mm));
  }
  if (options.face_px != 0 &&
      (options.face_px < kLeastFaceOption_px || options.face_px > kMostFaceOption_px)) {
    throw UsageError(fmt::format("a face's side is {} px; give 0 for the default, or {} to {}",
                                 options.face_px, kLeastFaceOption_px, kMostFaceOption_px));
  }
  if (options.mask &&
      (options.mask->type() != CV_8UC1 ||
       options.mask->size() != cv::Size(panoramas.frame.width, panoramas.frame.height))) {
    throw Error(
        fmt::format("the mask is {}x{}, but the panoramas of {} are {}x{}; make the mask for them "
                    "(raywalk-calibrate mask)",
                    options.mask->cols, options.mask->rows, panoramas.source.string(),
                    panoramas.frame.width, panoramas.frame.height));
  }
}

// COLMAP's directory, which is emptied for other inputs: in one that the user gives it has a name
// of its own, another for every calibration.
fs::path workspace_of(const PosesOptions& options) {
  if (options.work.empty()) return options.out / "colmap";
  const std::string calibration = sha256_hex(fs::absolute(options.out).string());
  return options.work / ("raywalk-colmap-" + calibration.substr(0, 16));
}

class PoseSolver {
 public:
  PoseSolver(const CaptureSet& set, const PosesOptions& options)
      : set_(set),
        options_(options),
        start_(nominal_poses(set)),
        nominal_(nominal_poses(stations_only(set))),
        crossings_(crossings_of(set)),
        threads_(options.threads > 0 ? options.threads : thread_count()),
        anchor_{kAnchorCells * cell_side_m(set, crossings_), kAnchor_rad} {
    for (std::size_t i = 0; i < options.start.size(); ++i) {
      if (options.start[i]) start_[i] = options.start[i];
    }
    result_.poses.resize(set.frames.size());
    result_.keyframes = choose_keyframes(set, crossings_, options.keyframes_mm);
    result_.faces = kFaceCount;
    result_.face_px = options.face_px > 0 ? options.face_px : default_face_px(set.frame.width);
    if (result_.keyframes.size() >= kLeastFrames) return;
    throw Error(fmt::format(
        "{}: {} of its {} stations are to be solved, but a scene point has to be seen from {}; "
        "capture more stations, or give a smaller --keyframes-mm",
        set.source.string(), result_.keyframes.size(), set.frames.size(), kLeastFrames));
  }

  PosesResult solve() {
    run_colmap();
    std::string fault = common_fault(set_, summary_.motions);
    const bool solved = fault.empty() && !refined_.points.observations.empty();
    if (solved) place_in_world();
    if (!solved && fault.empty()) fault = unsolved_reason();
    set_figures();
    result_.warnings = solved ? pose_warnings(set_, crossings_, summary_, result_)
                              : std::vector<std::string>{fault};
    if (solved) write_frame_poses(options_.out / "poses.json", set_, result_.poses);
    write_poses_report(options_.out, set_, result_);
    if (!solved) throw Error(fmt::format("{}: {}", set_.source.string(), fault));
    return result_;
  }

 private:
  void run_colmap() {
    const ColmapProgram colmap = ColmapProgram::find();
    const fs::path directory = workspace_of(options_);
    fs::path lock_file = directory;
    lock_file += ".lock";
    make_directories(directory_of(lock_file));
    const FileLock lock(lock_file, "another process is solving the same poses; wait for it to end");
    ColmapWorkspace workspace(set_, result_.keyframes, colmap,
                              {.directory = directory,
                               .face_px = result_.face_px,
                               .threads = threads_,
                               .mask = options_.mask,
                               .lenses = options_.lenses});
    match(&workspace);
    if (common_fault(set_, summary_.motions).empty()) refine_in_rounds(&workspace);
  }

  // `step` returns whether an earlier run has done it.
  template <typename Step>
  void timed(const std::string& name, const Step& step) {
    bool reused = false;
    const double seconds = times_of([&] { reused = step(); }).wall_s;
    result_.times.push_back({name, seconds, reused});
    spdlog::info("{}: {:.1f} s{}", name, seconds, reused ? " (done before)" : "");
  }

  void match(ColmapWorkspace* workspace) {
    timed("faces", [&] { return workspace->cut_faces(); });
    timed("features", [&] { return workspace->find_features(); });
    timed("matches", [&] {
      return workspace->match(choose_pairs(set_, crossings_, result_.keyframes), start_);
    });
    summary_.features = workspace->feature_counts();
    std::vector<std::vector<double>> evidence(set_.lines.size());
    for (const auto& [frames, pair] : workspace->matches()) {
      const auto [first, second] = frames;
      result_.matched_pairs += pair.face_pairs;
      for (const std::size_t frame : {first, second}) {
        summary_.matches[frame] += static_cast<int>(pair.matches.size());
      }
      const CaptureFrame& of = set_.frames[first];
      if (of.held_out() || of.line != set_.frames[second].line) continue;
      evidence[of.line].push_back(motion_evidence(*start_[first], *start_[second], pair.matches));
    }
    for (const std::vector<double>& of_line : evidence) {
      summary_.motions.push_back(rail_motion(of_line));
    }
  }

  // Initial poses of the first round: the held-out frames, and the keyframes of lines that do not
  // run against the slider.
  FramePoses first_poses() const {
    FramePoses poses(set_.frames.size());
    for (const std::size_t frame : result_.keyframes) {
      const CaptureFrame& of = set_.frames[frame];
      if (!of.held_out() && summary_.motions[of.line] == RailMotion::kReversed) continue;
      poses[frame] = start_[frame];
    }
    return poses;
  }

  void refine_in_rounds(ColmapWorkspace* workspace) {
    FramePoses poses = first_poses();
    for (std::size_t round = 0; round < kRounds.size(); ++round) {
      SeenPoints seen;
      timed(fmt::format("triangulation {}", round + 1), [&] {
        const bool last = round + 1 == kRounds.size();
        seen = strongest(widely_seen(workspace->triangulate(poses, kRounds[round]), kLeastFrames),
                         last ? points_at_last() : kPointsOnTheWay);
        return false;
      });
      if (seen.observations.empty()) {
        refined_ = {};
        return;
      }
      timed(fmt::format("adjustment {}", round + 1), [&] {
        refined_ = refine_poses(set_, poses, seen, anchor_, threads_);
        // Initial poses of the next round, including frames that found no points in this one.
        const FramePoses moved =
            aligned(refined_.poses, align_poses(set_, refined_.poses, nominal_));
        for (std::size_t i = 0; i < poses.size(); ++i) {
          if (moved[i]) poses[i] = moved[i];
        }
        return false;
      });
    }
    timed("accuracy", [&] {
      settle(&refined_, anchor_);
      return false;
    });
  }

  int points_at_last() const {
    const double each = kObservationsAtLast / static_cast<double>(result_.keyframes.size());
    return std::clamp(static_cast<int>(each), kLeastPointsAtLast, kMostPointsAtLast);
  }

  void place_in_world() {
    result_.alignment = align_poses(set_, refined_.poses, nominal_);
    result_.poses = aligned(refined_.poses, result_.alignment);
    result_.points = static_cast<int>(refined_.points.points_m.size());
    result_.observations = static_cast<int>(refined_.points.observations.size());
    result_.residual_px = refined_.noise_px;
  }

  std::string unsolved_reason() const {
    double features = 0.0;
    for (const auto& [frame, count] : summary_.features) features += count;
    return fmt::format(
        "no pose could be solved: {:.0f} features per panorama, {} pairs of faces match; the "
        "pictures are too plain, too dark or too far apart, or not of this capture{}: check them, "
        "capture stations closer together, or use --method rotation",
        features / static_cast<double>(result_.keyframes.size()), result_.matched_pairs,
        any_masks(set_) ? ", or their masks hide too much" : "");
  }

  void set_figures() {
    result_.lines = line_figures(set_, result_, start_);
    result_.crossings = crossing_figures(set_, crossings_, refined_.points);
    std::vector<double> position_mm;
    std::vector<double> rotation_deg;
    for (const std::size_t frame : result_.keyframes) {
      const auto& pose = result_.poses[frame];
      if (!pose) {
        result_.unposed.push_back({frame, unposed_reason(set_, summary_, frame)});
      } else if (!set_.frames[frame].held_out()) {
        position_mm.push_back(pose->position_sigma_mm);
        rotation_deg.push_back(pose->rotation_sigma_deg);
      }
    }
    if (position_mm.empty()) return;
    result_.position_sigma_mm = median(position_mm);
    result_.rotation_sigma_deg = median(rotation_deg);
  }

  const CaptureSet& set_;
  const PosesOptions& options_;
  FramePoses start_;    // initial poses
  FramePoses nominal_;  // of the stations
  std::vector<LineCrossing> crossings_;
  int threads_;
  PoseAnchor anchor_;
  MatchSummary summary_{};
  // Near the nominal poses, with sigmas; those of the largest connected group of frames. Empty if
  // nothing was solved.
  RefinedPoses refined_{};
  PosesResult result_{};
};

}  // namespace

PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options) {
  require_valid(panoramas, options);
  make_directories(options.out);
  return PoseSolver(panoramas, options).solve();
}

}  // namespace raywalk::calibrate
