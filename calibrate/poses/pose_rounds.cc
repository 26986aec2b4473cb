#include "calibrate/poses/pose_rounds.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/frame_links.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/rail_motion.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/fingerprint.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

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

// COLMAP's directory, which is emptied for other inputs: in one that the user gives it has a name
// of its own, another for every calibration.
fs::path workspace_of(const PosesOptions& options) {
  if (options.work.empty()) return options.out / "colmap";
  const std::string calibration = sha256_hex(fs::absolute(options.out).string());
  return options.work / ("raywalk-colmap-" + calibration.substr(0, 16));
}

int points_at_last(const PoseProblem& problem) {
  const double each = kObservationsAtLast / static_cast<double>(problem.keyframes.size());
  return std::clamp(static_cast<int>(each), kLeastPointsAtLast, kMostPointsAtLast);
}

class PoseRounds {
 public:
  explicit PoseRounds(const PoseProblem& problem) : problem_(problem), set_(problem.set) {}

  SolvedPoses solve() {
    const ColmapProgram colmap = ColmapProgram::find();
    const fs::path directory = workspace_of(problem_.options);
    fs::path lock_file = directory;
    lock_file += ".lock";
    make_directories(directory_of(lock_file));
    const FileLock lock(lock_file, "another process is solving the same poses; wait for it to end");
    ColmapWorkspace workspace(set_, problem_.keyframes, colmap,
                              {.directory = directory,
                               .face_px = problem_.face_px,
                               .threads = problem_.threads,
                               .mask = problem_.options.mask,
                               .lenses = problem_.options.lenses});
    match(&workspace);
    if (common_fault(set_, solved_.summary.motions).empty()) refine_in_rounds(&workspace);
    return std::move(solved_);
  }

 private:
  template <typename Step>
  void timed(const std::string& name, const Step& step) {
    bool reused = false;
    const double seconds = times_of([&] { reused = step(); }).wall_s;
    solved_.times.push_back({name, seconds, reused});
    spdlog::info("{}: {:.1f} s{}", name, seconds, reused ? " (done before)" : "");
  }

  void match(ColmapWorkspace* workspace) {
    timed("faces", [&] { return workspace->cut_faces(); });
    timed("features", [&] { return workspace->find_features(); });
    timed("matches", [&] {
      const auto pairs = choose_pairs(set_, problem_.crossings, problem_.keyframes);
      return workspace->match(pairs, problem_.start);
    });
    MatchSummary& summary = solved_.summary;
    summary.features = workspace->feature_counts();
    std::vector<std::vector<double>> evidence(set_.lines.size());
    for (const FrameMatches& pair : workspace->matches()) {
      const auto [first, second] = pair.frames;
      solved_.matched_pairs += pair.face_pairs;
      for (const int frame : {first, second}) {
        summary.matches[frame] += static_cast<int>(pair.matches.size());
      }
      const auto line = line_of(first);
      if (!line || line != line_of(second)) continue;
      evidence[*line].push_back(motion_evidence(*problem_.start[static_cast<std::size_t>(first)],
                                                *problem_.start[static_cast<std::size_t>(second)],
                                                pair.matches));
    }
    for (const std::vector<double>& of_line : evidence) {
      summary.motions.push_back(rail_motion(of_line));
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
    for (const int frame : problem_.keyframes) {
      const auto line = line_of(frame);
      const auto index = static_cast<std::size_t>(frame);
      if (line && solved_.summary.motions[*line] == RailMotion::kReversed) continue;
      poses[index] = problem_.start[index];
    }
    return poses;
  }

  void refine_in_rounds(ColmapWorkspace* workspace) {
    RefinedPoses& refined = solved_.refined;
    FramePoses poses = first_poses();
    for (std::size_t round = 0; round < kRounds.size(); ++round) {
      SeenPoints seen;
      timed(fmt::format("triangulation {}", round + 1), [&] {
        const bool last = round + 1 == kRounds.size();
        seen = strongest(widely_seen(workspace->triangulate(poses, kRounds[round]), kLeastFrames),
                         last ? points_at_last(problem_) : kPointsOnTheWay);
        return false;
      });
      if (seen.observations.empty()) {
        refined = {};
        return;
      }
      timed(fmt::format("adjustment {}", round + 1), [&] {
        refined = refine_poses(set_, poses, seen, problem_.anchor, problem_.threads);
        // Initial poses of the next round, including frames that found no points in this one.
        const PoseAlignment alignment = align_poses(set_, refined.poses, problem_.nominal);
        const FramePoses moved = aligned(refined.poses, alignment);
        for (std::size_t i = 0; i < poses.size(); ++i) {
          if (moved[i]) poses[i] = moved[i];
        }
        return false;
      });
    }
    timed("accuracy", [&] {
      settle(&refined, problem_.anchor);
      return false;
    });
  }

  const PoseProblem& problem_;
  const CaptureSet& set_;
  SolvedPoses solved_{};
};

}  // namespace

PoseProblem problem_of(const CaptureSet& set, const PosesOptions& options) {
  PoseProblem problem{.set = set,
                      .options = options,
                      .start = nominal_poses(set),
                      .nominal = nominal_poses(stations_only(set)),
                      .crossings = crossings_of(set)};
  for (std::size_t i = 0; i < options.start.size(); ++i) {
    if (options.start[i]) problem.start[i] = options.start[i];
  }
  problem.keyframes = choose_keyframes(set, problem.crossings, options.keyframes_mm);
  problem.face_px = options.face_px > 0 ? options.face_px : default_face_px(set.frame.width);
  problem.threads = options.threads > 0 ? options.threads : thread_count();
  problem.anchor = {kAnchorCells * cell_side_m(set, problem.crossings), kAnchor_rad};
  return problem;
}

SolvedPoses solve_in_rounds(const PoseProblem& problem) { return PoseRounds(problem).solve(); }

}  // namespace raywalk::calibrate
