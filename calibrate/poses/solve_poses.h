// Where every panorama was taken, from what the panoramas show: features found and matched by
// COLMAP 3.8 on flat faces of the panoramas, in rounds of triangulation (COLMAP) and bundle
// adjustment (refine_poses.h), from the nominal poses on.
#pragma once

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
  double keyframes_mm = 0;        // largest distance between the stations solved; 0: every station
  int face_px = 0;                // side of a face; 0: by the panoramas' resolution
  std::optional<cv::Mat> mask{};  // CV_8UC1 of the panoramas' size, 0 = not to be used
  std::optional<DualFisheyeLayout> lenses{};  // of panoramas stitched from two: their positions
  FramePoses start{};                         // where to start from; none: nominal
  std::filesystem::path out{};  // the calibration's directory, made where it is missing
  int threads = 0;              // of COLMAP and the adjustment; 0: as many as thread_count()
};

struct LinePoses {
  int line = 0;              // index into CaptureSet::lines
  int stations = 0;          // on the line
  int keyframes = 0;         // of them, those to be solved
  int posed = 0;             // of them, those that were
  int observations = 0;      // of scene points by all of them
  double residual_px = 0.0;  // root mean square, panorama 4096 wide
  // Where the line was found against where it was planned: largest over the stations.
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
  int frame = 0;  // index into CaptureSet::frames
  std::string reason{};
};

struct StepTime {
  std::string step{};
  double seconds = 0.0;
  bool reused = false;  // found finished by an earlier run
};

struct PosesResult {
  FramePoses poses{};
  std::vector<int> keyframes{};  // indices into CaptureSet::frames
  std::vector<LinePoses> lines{};
  std::vector<CrossingPoints> crossings{};
  std::vector<UnposedFrame> unposed{};  // keyframes only
  PoseAlignment alignment{};            // of the last round
  int face_px = 0;
  int faces = 0;          // of a panorama
  int matched_pairs = 0;  // of faces, that COLMAP verified
  int points = 0;         // of the scene
  int observations = 0;
  double residual_px = 0.0;        // robust standard deviation, panorama 4096 wide
  double position_sigma_mm = 0.0;  // median over the frames
  double rotation_sigma_deg = 0.0;
  std::vector<StepTime> times{};
  // What a user has to know: lines that nothing connects, frames left out, lines that are not where
  // they were planned.
  std::vector<std::string> warnings{};
};

// Writes poses.json, poses-report.json and poses.html, and works in the directory colmap/, where an
// interrupted run goes on and which may be deleted afterwards. Throws Error: no COLMAP 3.8, COLMAP
// failed (quoting its log), nothing could be solved (saying why: too few matches, a mirrored
// camera, …; poses-report.json and poses.html are written all the same), a mask of another size;
// UsageError for options out of range; Interrupted.
PosesResult solve_poses(const CaptureSet& panoramas, const PosesOptions& options);

}  // namespace raywalk::calibrate
