// Solves the poses of the panoramas: COLMAP finds and matches features on flat faces of the
// panoramas, then rounds of triangulation (COLMAP) and bundle adjustment (refine_poses.h) refine
// the nominal poses. Held-out frames are matched with the stations near them and adjusted with all
// others; the world frame and the scale are those of the stations alone.
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

struct CrossingPoints {
  int along_x = 0;  // indices into CaptureSet::lines
  int along_z = 0;
  int points = 0;  // scene points seen from both lines near the crossing
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
  FramePoses poses{};
  std::vector<std::size_t> keyframes{};  // indices into CaptureSet::frames
  std::vector<LinePoses> lines{};
  std::vector<CrossingPoints> crossings{};
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
  // Unconnected lines, frames without a pose, lines that are not where they were planned.
  std::vector<std::string> warnings{};
};

// Writes poses.json and poses-report.json. Works in the directory colmap/, from which
// an interrupted run is resumed and which may be deleted afterwards. Throws Error if there is no
// supported COLMAP, COLMAP fails (quoting its log), nothing can be solved (naming the reason: too
// few matches, a mirrored camera, …; poses-report.json is still written), or the
// mask has another size; UsageError for options out of range; Interrupted.
PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options);

}  // namespace raywalk::calibrate
