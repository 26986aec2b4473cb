// Solves the poses of the panoramas: COLMAP finds and matches features on flat faces of the
// panoramas, then rounds of triangulation (COLMAP) and adjustment (refine_poses.h) refine the
// nominal poses. Half of the scene points at the intersections of lines are held out of the last
// adjustment until they have measured how well the lines agree (intersection_check.h). Positions
// that agree with each other in the pictures win over the list of positions or the slider's
// feedback; what contradicts them is named (contradictions.h). Stations without a pose of their own
// are predicted from their rail. Held-out frames are matched with the stations near them and
// adjusted with all others; the world frame and the scale are those of the stations alone.
//
// COLMAP's own results differ from run to run, also with one thread: its matching
// starts from random numbers that cannot be set.
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/align_poses.h"
#include "calibrate/poses/contradictions.h"
#include "calibrate/poses/intersection_check.h"
#include "calibrate/rails/fit_rails.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

struct PosesOptions {
  double keyframes_mm = 0;  // largest distance between the stations solved; 0: every station
  int face_px = 0;          // side of a face; 0: default_face_px()
  // Of all frames: CV_8UC1 of the panoramas' size, 0 = masked. Masks of single frames
  // (frame_masks.h) are honoured as well.
  std::optional<cv::Mat> mask{};
  std::optional<DualFisheyeLayout> lenses{};  // of stitched panoramas: the lenses' positions
  FramePoses start{};                         // initial poses; empty: nominal
  std::filesystem::path out{};                // the calibration's directory, created if missing
  int threads = 0;                            // of COLMAP and the adjustment; 0: thread_count()
  // The folder in which COLMAP has its own, empty: `out`/colmap.
  std::filesystem::path work{};
};

struct LinePoses {
  std::size_t line = 0;      // index into CaptureSet::lines
  int stations = 0;          // on the line
  int keyframes = 0;         // stations to be solved
  int posed = 0;             // keyframes with a solved pose
  int observations = 0;      // of scene points by all of them
  double residual_px = 0.0;  // root mean square, panorama 4096 wide
  // Largest difference of a station's pose from the plan.
  double moved_mm = 0.0;
  double turned_deg = 0.0;
};

struct MeasuredIntersection {
  IntersectionCheck check{};
  // Change of the relative pose of the two lines' nearest stations, from the plan.
  double correction_mm = 0.0;
  double correction_deg = 0.0;
  std::vector<std::string> faults{};  // why the lines cannot be trusted to agree here
};

// A frame without a pose, and why.
struct UnposedFrame {
  std::size_t frame = 0;  // index into CaptureSet::frames
  std::string reason{};
};

struct StepTime {
  std::string step{};
  double seconds = 0.0;
  bool reused = false;  // done by an earlier run
};

struct PosesResult {
  FramePoses poses{};  // of all stations, and of the held-out frames that were solved
  std::vector<std::size_t> keyframes{};  // indices into CaptureSet::frames
  std::vector<Rail> rails{};             // by line
  std::vector<LinePoses> lines{};
  std::vector<MeasuredIntersection> intersections{};
  std::vector<Contradiction> contradictions{};
  std::vector<UnposedFrame> unposed{};  // keyframes only, held-out frames among them
  PoseAlignment alignment{};            // of the last round
  int face_px = 0;
  std::size_t faces = 0;  // of each panorama
  int matched_pairs = 0;  // of faces, verified by COLMAP
  int points = 0;         // of the scene
  int observations = 0;
  double residual_px = 0.0;        // robust standard deviation, panorama 4096 wide
  double position_sigma_mm = 0.0;  // median over the stations
  double rotation_sigma_deg = 0.0;
  std::vector<StepTime> times{};
  // Why the poses are not trustworthy: contradictions, lines that are not connected or do not
  // agree, frames without a pose. The exit code of the commands is 1 if there are any.
  std::vector<std::string> warnings{};
  std::vector<std::string> notes{};  // no problem
  bool trustworthy() const { return warnings.empty(); }
};

// Writes poses.json (docs/file-formats.md). Works in the directory colmap/, from which an
// interrupted run is resumed and which may be deleted afterwards. Throws Error if there is no
// supported COLMAP, COLMAP fails (quoting its log), nothing can be solved (naming the reason: too
// few matches, a mirrored camera, …), or the mask has another size; UsageError for options out of
// range; Interrupted.
PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options);

}  // namespace raywalk::calibrate
