// The fisheye pictures of a capture with what its panoramas were stitched by: frames in other axes
// are made from them in the same way.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/stitch/lens_balance.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct FisheyeSource {
  CaptureSet captured{};       // of layout kDualFisheye
  DualFisheyeCamera camera{};  // at the size of its pictures
  int width = 0;               // of the panoramas, pixels
  StitcherOptions options{};
  LensBalance balance{};
};

// The camera at the size of a set's pictures. Throws UsageError without a camera; Error naming the
// station whose number of files is not the camera's, or for another aspect ratio.
DualFisheyeCamera fitting_camera(const CaptureSet& set,
                                 const std::optional<DualFisheyeCamera>& camera);

// Of the panoramas that the step `stitch` made in the directory OUT. Throws Error naming the step
// if its record there is missing, damaged or of an unfinished run, and as fitting_camera.
FisheyeSource read_fisheye_source(const CaptureSet& captured,
                                  const std::optional<DualFisheyeCamera>& camera,
                                  const std::filesystem::path& out);

// All values of a camera's lenses, as text for a fingerprint.
std::string camera_text(const DualFisheyeCamera& camera);

// All that pictures made from a source depend on, except the files of its frames.
std::string source_text(const FisheyeSource& source);

// CV_8UC3; the same picture twice for cameras with one file.
struct FramePictures {
  cv::Mat front{};
  cv::Mat back{};
  cv::Mat mask{};  // CV_8UC1 of their size, 0 = masked; empty: nothing is
};

// Throws Error as own_mask (frame_masks.h), and naming the file if it is unreadable or damaged, of
// another size than the camera's pictures, or bright outside of the image circles.
FramePictures read_frame_pictures(const CaptureFrame& frame, const DualFisheyeCamera& camera);

}  // namespace raywalk::calibrate
