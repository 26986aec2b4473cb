#include "calibrate/poses/solve_poses.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/matching_faces.h"
#include "calibrate/poses/pose_accuracy.h"
#include "calibrate/poses/poses_document.h"
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
constexpr int kMostPointsAtLast = 3000;
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
      : listed_(set),
        set_(set),
        options_(options),
        start_(nominal_poses(set)),
        nominal_(nominal_poses(stations_only(set))),
        intersections_(intersections_of(set)),
        threads_(options.threads > 0 ? options.threads : thread_count()),
        anchor_{kAnchorCells * cell_side_m(set, intersections_), kAnchor_rad} {
    for (std::size_t i = 0; i < options.start.size(); ++i) {
      if (options.start[i]) start_[i] = options.start[i];
    }
    result_.poses.resize(set.frames.size());
    result_.keyframes = choose_keyframes(set, intersections_, options.keyframes_mm);
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
    if (fault.empty() && refined_.points.observations.empty()) fault = unsolved_reason();
    if (!fault.empty()) throw Error(fmt::format("{}: {}", set_.source.string(), fault));
    place_in_world();
    set_figures();
    add_warnings(listed_, &result_);
    write_poses(options_.out / "poses.json", listed_, result_);
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
    if (!common_fault(set_, summary_.motions).empty()) return;
    turn_reversed_lines();
    refine_in_rounds(&workspace);
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
      return workspace->match(choose_pairs(set_, intersections_, result_.keyframes), start_);
    });
    summary_.features = workspace->feature_counts();
    std::vector<std::vector<PairMotion>> pairs(set_.lines.size());
    for (const auto& [frames, pair] : workspace->matches()) {
      const auto [first, second] = frames;
      result_.matched_pairs += pair.face_pairs;
      for (const std::size_t frame : {first, second}) {
        summary_.matches[frame] += static_cast<int>(pair.matches.size());
      }
      const CaptureFrame& of = set_.frames[first];
      if (of.held_out() || of.line != set_.frames[second].line) continue;
      pairs[of.line].push_back(pair_motion(*start_[first], *start_[second], pair.matches));
    }
    for (const std::vector<PairMotion>& of_line : pairs) {
      summary_.motions.push_back(line_motion(of_line));
    }
  }

  // A line whose pictures move against the slider was listed in reverse order: its stations take
  // each other's places.
  void turn_reversed_lines() {
    for (std::size_t i = 0; i < set_.lines.size(); ++i) {
      if (summary_.motions[i].along != RailMotion::kReversed) continue;
      std::vector<int>& frames = set_.lines[i].frames;
      result_.contradictions.push_back(
          {"reversed",
           {frames.begin(), frames.end()},
           fmt::format(
               "line {}: its pictures move against the slider, unlike those of the others: "
               "the rail was laid the other way round, or its pictures are in reverse order",
               set_.lines[i].id)});
      std::ranges::reverse(frames);
      for (std::size_t at = 0; at < frames.size(); ++at) {
        const CaptureFrame& place = listed_.frames[listed_.lines[i].frames[at]];
        set_.frames[frames[at]].nominal_m = place.nominal_m;
        nominal_[frames[at]]->position_m = start_[frames[at]]->position_m = place.nominal_m;
      }
    }
  }

  void refine_in_rounds(ColmapWorkspace* workspace) {
    FramePoses poses(set_.frames.size());
    for (const std::size_t frame : result_.keyframes) poses[frame] = start_[frame];
    for (std::size_t round = 0; round < kRounds.size(); ++round) {
      const bool last = round + 1 == kRounds.size();
      SeenPoints seen;
      timed(fmt::format("triangulation {}", round + 1), [&] {
        seen = strongest(widely_seen(workspace->triangulate(poses, kRounds[round]), kLeastFrames),
                         last ? points_at_last() : kPointsOnTheWay);
        return false;
      });
      if (seen.observations.empty()) {
        refined_ = {};
        return;
      }
      timed(fmt::format("adjustment {}", round + 1), [&] {
        if (last) {
          adjust_and_check(poses, seen);
        } else {
          move_to(refine_poses(set_, poses, seen, anchor_, threads_).poses, &poses);
        }
        return false;
      });
    }
  }

  // Initial poses of the next round, including frames that found no points in this one.
  void move_to(const FramePoses& refined, FramePoses* poses) const {
    const FramePoses moved = aligned(refined, align_poses(set_, refined, nominal_));
    for (std::size_t i = 0; i < poses->size(); ++i) {
      if (moved[i]) (*poses)[i] = moved[i];
    }
  }

  // Adjusts to the points that are not held out, measures the intersections by the others, and
  // adjusts to all.
  void adjust_and_check(const FramePoses& start, const SeenPoints& seen) {
    const DividedPoints points = divide_points(set_, intersections_, seen);
    // Of very few points all may be held out.
    const SeenPoints& used = points.used.observations.empty() ? seen : points.used;
    refined_ = refine_poses(set_, start, used, anchor_, threads_);
    FramePoses poses = start;
    move_to(refined_.poses, &poses);
    settle(&refined_, anchor_);
    for (const IntersectionCheck& check : check_intersections(set_, intersections_, refined_.poses,
                                                              refined_.noise_px, points.held_out)) {
      result_.intersections.push_back({.check = check});
    }
    if (points.held_out.observations.empty()) return;
    refined_ = refine_poses(set_, poses, seen, anchor_, threads_, fit_rails(set_, poses));
    settle(&refined_, anchor_);
  }

  int points_at_last() const {
    const double each = kObservationsAtLast / static_cast<double>(result_.keyframes.size());
    return std::clamp(static_cast<int>(each), kLeastPointsAtLast, kMostPointsAtLast);
  }

  // The world is that of the stations whose listed positions agree with the pictures.
  void place_in_world() {
    FramePoses believed = nominal_;
    align_and_fit(believed);
    std::vector<Contradiction> found = contradictions_of(set_, result_.poses, result_.rails);
    if (!found.empty()) {
      for (const Contradiction& contradiction : found) {
        for (const std::size_t frame : contradiction.frames) believed[frame].reset();
      }
      const auto left = std::ranges::count_if(believed, [](const auto& pose) { return !!pose; });
      if (2 * static_cast<std::size_t>(left) > believed.size()) align_and_fit(believed);
    }
    std::ranges::move(found, std::back_inserter(result_.contradictions));
    for (std::size_t i = 0; i < set_.stations(); ++i) {
      if (result_.poses[i]) continue;
      result_.poses[i] = pose_on_rail(set_, result_.rails[set_.frames[i].line], i);
      if (result_.rails[set_.frames[i].line].stations == 0) result_.poses[i] = start_[i];
    }
    result_.points = static_cast<int>(refined_.points.points_m.size());
    result_.observations = static_cast<int>(refined_.points.observations.size());
    result_.residual_px = refined_.noise_px;
  }

  void align_and_fit(const FramePoses& believed) {
    result_.alignment = align_poses(set_, refined_.poses, believed);
    result_.poses = aligned(refined_.poses, result_.alignment);
    result_.rails = fit_rails(set_, result_.poses);
  }

  std::string unsolved_reason() const {
    double features = 0.0;
    for (const auto& [frame, count] : summary_.features) features += count;
    return fmt::format(
        "no pose could be solved: {:.0f} features per panorama, {} pairs of faces match; the "
        "pictures are too plain, too dark or too far apart, or not of this capture{}: check them, "
        "capture stations closer together",
        features / static_cast<double>(result_.keyframes.size()), result_.matched_pairs,
        any_masks(set_) ? ", or their masks hide too much" : "");
  }

  void set_figures() {
    result_.lines = line_figures(listed_, result_, start_);
    for (MeasuredIntersection& intersection : result_.intersections) {
      set_correction(set_, start_, result_.poses, &intersection);
      intersection.faults = intersection_faults(set_, intersection.check, station_spacing_m(set_));
    }
    std::vector<double> position_mm;
    std::vector<double> rotation_deg;
    for (const std::size_t frame : result_.keyframes) {
      const auto& pose = result_.poses[frame];
      if (!pose || pose->origin != PoseOrigin::kSolved) {
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

  const CaptureSet& listed_;
  CaptureSet set_;  // with reversed lines turned round
  const PosesOptions& options_;
  FramePoses start_;    // initial poses
  FramePoses nominal_;  // of the stations
  std::vector<LineIntersection> intersections_;
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
