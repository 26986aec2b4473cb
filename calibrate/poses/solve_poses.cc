#include "calibrate/poses/solve_poses.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/frame_links.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/pose_covariance.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/poses_report.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/refine_poses.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"

namespace raywalk::calibrate {
namespace {

// From wide, as the nominal poses are degrees off, to the accuracy of the features.
constexpr std::array kRounds{TriangulationRound{6.0, 25.0}, TriangulationRound{2.0, 6.0},
                             TriangulationRound{1.0, 1.5}};
// Scene points per panorama in the adjustments before the last one, and in the last one.
constexpr int kPointsOnTheWay = 300;
constexpr int kPointsAtLast = 1500;
constexpr int kLeastFrames = 3;  // of a point; with two frames, one direction is not checked
// Sigmas of the prior at a round's initial poses, in cells and radians: far beyond the errors of
// placing a rail, and thousands of times the uncertainty by the pictures.
constexpr double kAnchorCells = 0.1;
constexpr double kAnchor_rad = 0.1;
constexpr int kLeastFaceOption_px = 64;
constexpr int kMostFaceOption_px = 4096;

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
  }

  PosesResult solve() {
    require_enough_keyframes();
    const ColmapProgram colmap = ColmapProgram::find();
    ColmapWorkspace workspace(set_, result_.keyframes, colmap,
                              {.directory = options_.out / "colmap",
                               .face_px = result_.face_px,
                               .threads = threads_,
                               .mask = options_.mask,
                               .lenses = options_.lenses});
    match(&workspace);
    std::string fault = common_fault(set_, summary_.motions);
    if (fault.empty()) {
      refine_in_rounds(&workspace);
      if (!solved_) fault = unsolved_reason();
    }
    write_reports(fault);
    if (!fault.empty()) throw Error(fmt::format("{}: {}", set_.source.string(), fault));
    return result_;
  }

 private:
  void require_enough_keyframes() const {
    if (result_.keyframes.size() >= static_cast<std::size_t>(kLeastFrames)) return;
    throw Error(fmt::format(
        "{}: {} of its {} stations are to be solved, but a scene point has to be seen from {}; "
        "capture more stations, or give a smaller --keyframes-mm",
        set_.source.string(), result_.keyframes.size(), set_.frames.size(), kLeastFrames));
  }

  template <typename Step>
  void timed(const std::string& name, const Step& step) {
    bool reused = false;
    const double seconds = times_of([&] { reused = step(); }).wall_s;
    result_.times.push_back({name, seconds, reused});
    spdlog::info("{}: {:.1f} s{}", name, seconds, reused ? " (done before)" : "");
  }

  void match(ColmapWorkspace* workspace) {
    const std::vector<FramePair> pairs = choose_pairs(set_, crossings_, result_.keyframes);
    timed("faces", [&] { return workspace->cut_faces(); });
    timed("features", [&] { return workspace->find_features(); });
    timed("matches", [&] { return workspace->match(pairs, start_); });
    result_.matched_pairs = workspace->matched_face_pairs();
    summary_.features = workspace->feature_counts();
    std::vector<std::vector<double>> evidence(set_.lines.size());
    for (const FrameMatches& pair : workspace->matches()) {
      const auto [first, second] = pair.frames;
      summary_.matches[first] += static_cast<int>(pair.matches.size());
      summary_.matches[second] += static_cast<int>(pair.matches.size());
      const auto line = line_of(first);
      if (!line || line != line_of(second)) continue;
      evidence[*line].push_back(motion_evidence(*start_[static_cast<std::size_t>(first)],
                                                *start_[static_cast<std::size_t>(second)],
                                                pair.matches));
    }
    for (const std::vector<double>& of_line : evidence) {
      summary_.motions.push_back(rail_motion(of_line));
    }
  }

  // nullopt for a held-out frame.
  std::optional<std::size_t> line_of(int frame) const {
    const CaptureFrame& of = set_.frames[static_cast<std::size_t>(frame)];
    if (of.held_out()) return std::nullopt;
    return static_cast<std::size_t>(of.line);
  }

  // Initial poses of the first round: the held-out frames, and the keyframes of lines that do not
  // run against the slider.
  FramePoses first_poses() const {
    FramePoses poses(set_.frames.size());
    for (const int frame : result_.keyframes) {
      const auto line = line_of(frame);
      const auto index = static_cast<std::size_t>(frame);
      if (line && summary_.motions[*line] == RailMotion::kReversed) continue;
      poses[index] = start_[index];
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
                         last ? kPointsAtLast : kPointsOnTheWay);
        return false;
      });
      if (seen.observations.empty()) return;
      timed(fmt::format("adjustment {}", round + 1), [&] {
        refined_ = refine_poses(set_, poses, seen, anchor_, threads_);
        // Initial poses of the next round, including frames that found no points in this one.
        const PoseAlignment alignment = align_poses(set_, refined_.poses, nominal_);
        const FramePoses moved = aligned(refined_.poses, alignment);
        for (std::size_t i = 0; i < poses.size(); ++i) {
          if (moved[i]) poses[i] = moved[i];
        }
        return false;
      });
    }
    timed("accuracy", [&] {
      finish();
      return false;
    });
  }

  // Keeps the largest connected group of frames, with sigmas, in the world frame.
  void finish() {
    const SeenPoints inliers = widely_seen(inliers_of(refined_), 2);
    const std::vector<int> groups =
        linked_groups(static_cast<int>(set_.frames.size()), inliers, kLeastSharedPoints);
    const int main = largest_group(groups);
    for (std::size_t i = 0; i < groups.size(); ++i) {
      std::optional<FramePose>& pose = refined_.poses[i];
      if (pose && (main < 0 || groups[i] != main || pose->observations < kLeastObservations)) {
        pose.reset();
      }
    }
    keep_posed_observations();
    if (refined_.points.observations.empty()) return;
    set_sigmas(&refined_, anchor_);
    result_.alignment = align_poses(set_, refined_.poses, nominal_);
    result_.poses = aligned(refined_.poses, result_.alignment);
    result_.points = static_cast<int>(refined_.points.points_m.size());
    result_.observations = static_cast<int>(refined_.points.observations.size());
    result_.residual_px = refined_.noise_px;
    solved_ = true;
  }

  void keep_posed_observations() {
    SeenPoints kept;
    kept.points_m = refined_.points.points_m;
    std::vector<double> errors_px;
    for (std::size_t i = 0; i < refined_.points.observations.size(); ++i) {
      const PointObservation& observation = refined_.points.observations[i];
      if (!refined_.poses[static_cast<std::size_t>(observation.frame)]) continue;
      if (refined_.errors_px[i] > refined_.inlier_px) continue;
      kept.observations.push_back(observation);
      errors_px.push_back(refined_.errors_px[i]);
    }
    refined_.points = std::move(kept);
    refined_.errors_px = std::move(errors_px);
  }

  std::string unsolved_reason() const {
    int features = 0;
    for (const auto& [frame, count] : summary_.features) features += count;
    const double each =
        result_.keyframes.empty()
            ? 0.0
            : static_cast<double>(features) / static_cast<double>(result_.keyframes.size());
    return fmt::format(
        "no pose could be solved: {:.0f} features per panorama, {} pairs of faces match; the "
        "pictures are too plain, too dark or too far apart, or not of this capture{}: check them, "
        "capture stations closer together, or use --method rotation",
        each, result_.matched_pairs, any_masks(set_) ? ", or their masks hide too much" : "");
  }

  // Fills in the figures and writes the files, poses.json only if there are poses.
  void write_reports(const std::string& fault) {
    result_.lines = line_figures(set_, result_, start_);
    result_.crossings = crossing_figures(set_, crossings_, inliers_of(refined_));
    std::vector<double> position_mm;
    std::vector<double> rotation_deg;
    for (const int frame : result_.keyframes) {
      const auto& pose = result_.poses[static_cast<std::size_t>(frame)];
      if (!pose) {
        result_.unposed.push_back({frame, unposed_reason(set_, summary_, frame)});
        continue;
      }
      if (set_.frames[static_cast<std::size_t>(frame)].held_out()) continue;
      position_mm.push_back(pose->position_sigma_mm);
      rotation_deg.push_back(pose->rotation_sigma_deg);
    }
    if (!position_mm.empty()) {
      result_.position_sigma_mm = median(position_mm);
      result_.rotation_sigma_deg = median(rotation_deg);
    }
    result_.warnings = fault.empty() ? pose_warnings(set_, crossings_, summary_, result_)
                                     : std::vector<std::string>{fault};
    for (const std::string& warning : result_.warnings) spdlog::warn("{}", warning);
    if (solved_) write_frame_poses(options_.out / "poses.json", set_, result_.poses);
    write_poses_report(options_.out, set_, start_, result_);
  }

  const CaptureSet& set_;
  const PosesOptions& options_;
  FramePoses start_;
  FramePoses nominal_;  // of the stations
  std::vector<LineCrossing> crossings_;
  int threads_;
  PoseAnchor anchor_;
  MatchSummary summary_{};
  RefinedPoses refined_{};
  bool solved_ = false;
  PosesResult result_{};
};

void require_valid(const CaptureSet& panoramas, const PosesOptions& options) {
  if (panoramas.layout != FrameLayout::kPanorama) {
    throw Error(
        fmt::format("{}: its frames are not panoramas; run raywalk-calibrate stitch "
                    "first",
                    panoramas.source.string()));
  }
  if (!options.start.empty() && options.start.size() != panoramas.frames.size()) {
    throw UsageError(fmt::format("there are {} poses to start from, but {} stations",
                                 options.start.size(), panoramas.frames.size()));
  }
  if (!(options.keyframes_mm >= 0.0)) {
    throw UsageError(
        fmt::format("the distance of keyframes is {} mm; give 0 for every station, or "
                    "more",
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
        fmt::format("the mask is {}x{}, but the panoramas of {} are {}x{}; make the mask "
                    "for them (raywalk-calibrate mask)",
                    options.mask->cols, options.mask->rows, panoramas.source.string(),
                    panoramas.frame.width, panoramas.frame.height));
  }
}

}  // namespace

PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options) {
  require_valid(panoramas, options);
  make_directories(options.out);
  return PoseSolver(panoramas, options).solve();
}

}  // namespace raywalk::calibrate
