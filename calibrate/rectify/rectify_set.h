// The step `rectify`: lists the frames with their poses for raywalk-build-lf; those of fisheye
// pictures are made anew, in world axes.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_masks.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/stitch/stitch_record.h"
#include "core/geometry/grid.h"

namespace raywalk::calibrate {

struct RectifyOptions {
  // Of all frames: CV_8UC1 of the panoramas' size in the camera's frame, 0 = masked. Masks of
  // single frames (frame_masks.h) are honoured as well.
  std::optional<cv::Mat> mask{};
  GridTolerance tolerance{};  // how the lines of the capture were found
  // What the panoramas were stitched from: frames are then made straight from it. nullopt: the
  // panoramas are the captured pictures, which are listed as they are.
  std::optional<FisheyeSource> fisheye{};
  // Poses before the calibration, for comparison; empty: nominal_poses.
  FramePoses start{};
  std::filesystem::path out{};  // of the calibration
};

// The comparison of two lines' pictures at an intersection.
struct IntersectionComparison {
  int along_x = 0;  // indices into CaptureSet::lines
  int along_z = 0;
  std::string frame_x{}, frame_z{};  // the frames compared
  std::filesystem::path before{};    // overlay pictures, relative to OUT
  std::filesystem::path after{};
  double difference_before = 0.0;  // root mean square of grey levels
  double difference_after = 0.0;
};

struct RectifyResult {
  std::vector<std::string> files{};     // by frame, as the lists name them; "": without a pose
  int frames = 0;                       // in poses.csv
  int validation_frames = 0;            // in gt.csv: of validation lines, or held out
  std::vector<std::string> left_out{};  // frames without a pose
  std::vector<IntersectionComparison> intersections{};
  // The --line-tolerance-mm for raywalk-build-lf pack; 0: not needed. nullopt: none is enough.
  std::optional<double> line_tolerance_mm{};
  MaskFigures masks{};  // of single frames
  // Its --same-station-mm; nullopt: the default.
  std::optional<double> same_station_mm{};
};

// Writes OUT/rectified/ (rectified_frames.h) where there are fisheye pictures, OUT/intersections/
// with the overlays, OUT/poses.csv, OUT/gt.csv if there are validation lines or held-out frames,
// OUT/before.csv (the stations before the calibration: a room packed of it shows what the
// calibration gains, by raywalk-render validate), and rectify.json. The lists are frame lists
// (frame_list.h) with the names of lines. They name captured and stitched panoramas as they are,
// with their attitudes, by paths relative to OUT if both are in one folder, else absolute; their
// masks are joined with that of all frames in OUT/joined_masks/. Throws Error if no frame has a
// pose, or a file cannot be read or written; Interrupted.
RectifyResult rectify_set(const CaptureSet& panoramas, const FramePoses& poses,
                          const RectifyOptions& options);

}  // namespace raywalk::calibrate
