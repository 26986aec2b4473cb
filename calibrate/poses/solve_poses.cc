#include "calibrate/poses/solve_poses.h"

#include <fmt/format.h>

#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/frame_links.h"
#include "calibrate/poses/matching_faces.h"
#include "calibrate/poses/pose_rounds.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/refine_poses.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/atomic_output.h"

namespace raywalk::calibrate {
namespace {

constexpr int kLeastFaceOption_px = 64;
constexpr int kMostFaceOption_px = 4096;

// Makes the result of solved poses, and its files.
class PoseResults {
 public:
  PoseResults(const PoseProblem& problem, SolvedPoses solved)
      : problem_(problem),
        set_(problem.set),
        out_(problem.options.out),
        summary_(std::move(solved.summary)),
        refined_(std::move(solved.refined)) {
    result_.poses.resize(set_.frames.size());
    result_.keyframes = problem.keyframes;
    result_.faces = kFaceCount;
    result_.face_px = problem.face_px;
    result_.matched_pairs = solved.matched_pairs;
    result_.times = std::move(solved.times);
  }

  PosesResult write() {
    std::string fault = common_fault(set_, summary_.motions);
    if (fault.empty()) {
      if (!refined_.points.observations.empty()) place_in_world();
      if (!solved_) fault = unsolved_reason();
    }
    write_reports(fault);
    if (!fault.empty()) throw Error(fmt::format("{}: {}", set_.source.string(), fault));
    return result_;
  }

 private:
  void place_in_world() {
    result_.alignment = align_poses(set_, refined_.poses, problem_.nominal);
    result_.poses = aligned(refined_.poses, result_.alignment);
    result_.points = static_cast<int>(refined_.points.points_m.size());
    result_.observations = static_cast<int>(refined_.points.observations.size());
    result_.residual_px = refined_.noise_px;
    solved_ = true;
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
    result_.lines = line_figures(set_, result_, problem_.start);
    result_.crossings = crossing_figures(set_, problem_.crossings, inliers_of(refined_));
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
    result_.warnings = fault.empty() ? pose_warnings(set_, problem_.crossings, summary_, result_)
                                     : std::vector<std::string>{fault};
    if (solved_) write_frame_poses(out_ / "poses.json", set_, result_.poses);
    write_poses_report(out_, set_, result_);
  }

  const PoseProblem& problem_;
  const CaptureSet& set_;
  const std::filesystem::path& out_;
  MatchSummary summary_;
  RefinedPoses refined_;
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

void require_enough_keyframes(const PoseProblem& problem) {
  if (problem.keyframes.size() >= static_cast<std::size_t>(kLeastFrames)) return;
  throw Error(fmt::format(
      "{}: {} of its {} stations are to be solved, but a scene point has to be seen from {}; "
      "capture more stations, or give a smaller --keyframes-mm",
      problem.set.source.string(), problem.keyframes.size(), problem.set.frames.size(),
      kLeastFrames));
}

PoseProblem valid_problem(const CaptureSet& panoramas, const PosesOptions& options) {
  require_valid(panoramas, options);
  make_directories(options.out);
  PoseProblem problem = problem_of(panoramas, options);
  require_enough_keyframes(problem);
  return problem;
}

}  // namespace

PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options) {
  const PoseProblem problem = valid_problem(panoramas, options);
  return PoseResults(problem, solve_in_rounds(problem)).write();
}

}  // namespace raywalk::calibrate
