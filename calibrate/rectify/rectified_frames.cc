#include "calibrate/rectify/rectified_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibrate/base/frame_masks.h"
#include "calibrate/stitch/fisheye_frames.h"
#include "calibrate/stitch/stitcher.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/output_folder.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDirectory = "rectified";

// What all frames are made from.
struct RectifyInputs {
  const FisheyeSource& fisheye;
  const CaptureSet& panoramas;
  const cv::Mat& mask;  // of all frames

  bool masks(int index) const {
    return !mask.empty() || panoramas.frames[static_cast<std::size_t>(index)].mask.has_value();
  }
};

// Indices of the frames with a pose, ascending.
std::vector<int> posed_frames(const FramePoses& poses) {
  std::vector<int> posed;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) posed.push_back(static_cast<int>(i));
  }
  return posed;
}

std::string text_of(const fs::path& file) {
  return fmt::format(" {} {}", fs::absolute(file).string(), stamp_of(file).text());
}

// Fingerprint of everything that the pictures depend on.
std::string fingerprint_of(const RectifyInputs& inputs, const FramePoses& poses) {
  const FisheyeSource& fisheye = inputs.fisheye;
  std::string text = "fisheye " + settings_text(fisheye.camera, fisheye.width, fisheye.options);
  for (const double gain : fisheye.back_gain) text += fmt::format("{} ", gain);
  for (const int index : posed_frames(poses)) {
    const auto i = static_cast<std::size_t>(index);
    const CaptureFrame& frame = fisheye.captured.frames[i];
    text += frame.name + text_of(frame.file);
    if (frame.back) text += text_of(*frame.back);
    for (const double element : poses[i]->world_from_camera.reshaped()) {
      text += fmt::format(" {:.17g}", element);
    }
    if (frame.mask) text += text_of(*frame.mask);
    text += '\n';
  }
  if (!inputs.mask.empty()) text += sha256_of_pixels(inputs.mask);
  return sha256_hex(text);
}

// Prepares the partial directory: emptied unless it has the same inputs.
void prepare(const fs::path& partial, const std::string& inputs) {
  const fs::path inputs_file = partial / "inputs.txt";
  if (!fs::exists(inputs_file) || read_file(inputs_file) != inputs) {
    fs::remove_all(partial);
    make_directories(partial / "masks");
    write_file_atomically(inputs_file, inputs);
  }
}

void write_mask(const RectifyInputs& inputs, int index, const cv::Mat& rectified,
                const fs::path& file) {
  if (cv::countNonZero(rectified) > 0) return write_image(file, rectified);
  const CaptureFrame& frame = inputs.panoramas.frames[static_cast<std::size_t>(index)];
  throw Error(fmt::format(
      "{}: of what the mask of frame {} leaves, nothing remains after rotation; give it a mask "
      "that leaves more than single pixels",
      frame.where.empty() ? inputs.panoramas.source.string() : frame.where, frame.name));
}

// Where the files of a frame go.
struct FrameFiles {
  fs::path picture{};
  fs::path mask{};  // empty: it has none
};

FrameFiles files_of(const RectifyInputs& inputs, int index, const fs::path& directory) {
  const CaptureFrame& frame = inputs.panoramas.frames[static_cast<std::size_t>(index)];
  FrameFiles files{.picture = directory / rectified_file(frame).filename()};
  if (inputs.masks(index)) {
    files.mask = directory / "masks" / rectified_mask_file(frame).filename();
  }
  return files;
}

bool are_there(const FrameFiles& files) {
  return fs::exists(files.picture) && (files.mask.empty() || fs::exists(files.mask));
}

void write_frame(const RectifyInputs& inputs, int index, const FramePose& pose,
                 const FrameFiles& files) {
  const FisheyeSource& source = inputs.fisheye;
  const FramePictures pictures =
      read_frame_pictures(source.captured.frames[static_cast<std::size_t>(index)], source.camera);
  const Stitcher stitcher(source.camera, source.width, source.options, source.back_gain,
                          pose.world_from_camera);
  StitchedFrame made = stitcher.stitch(pictures.front, pictures.back, pictures.mask);
  if (!inputs.mask.empty()) {
    const cv::Mat common = rotate_mask(inputs.mask, pose.world_from_camera);
    made.mask = made.mask.empty() ? common : made.mask & common;
  }
  if (!files.mask.empty()) write_mask(inputs, index, made.mask, files.mask);
  write_image(files.picture, made.panorama);
}

void move_into_place(const fs::path& partial, const fs::path& directory, bool masked) {
  fs::remove(partial / "inputs.txt");
  if (!masked) fs::remove(partial / "masks");
  raywalk::move_into_place(partial, directory);
}

bool any_masked(const RectifyInputs& inputs, const std::vector<int>& frames) {
  return std::any_of(frames.begin(), frames.end(), [&](int frame) { return inputs.masks(frame); });
}

// Writes those of the frames that are not in the directory.
void write_missing(const RectifyInputs& inputs, const FramePoses& poses,
                   const std::vector<int>& frames, const fs::path& directory) {
  Progress progress("Rectifying", static_cast<std::int64_t>(frames.size()), "frames");
  const int at_once = frames_at_once(inputs.fisheye.camera, inputs.fisheye.width, true);
  for_each_frame(frames.size(), at_once, [&](std::size_t i) {
    const int index = frames[i];
    const FrameFiles files = files_of(inputs, index, directory);
    if (!are_there(files)) {
      write_frame(inputs, index, *poses[static_cast<std::size_t>(index)], files);
    }
    progress.advance();
  });
}

}  // namespace

fs::path rectified_file(const CaptureFrame& frame) {
  return fs::path(kDirectory) / (frame.name + ".png");
}

fs::path rectified_mask_file(const CaptureFrame& frame) {
  return fs::path(kDirectory) / "masks" / (frame.name + ".png");
}

void write_rectified_frames(const FisheyeSource& fisheye, const CaptureSet& panoramas,
                            const FramePoses& poses, const cv::Mat& mask, const fs::path& out) {
  const RectifyInputs inputs{fisheye, panoramas, mask};
  const fs::path directory = out / kDirectory;
  fs::path partial = directory;
  partial += ".partial";
  prepare(partial, fingerprint_of(inputs, poses));
  const std::vector<int> frames = posed_frames(poses);
  write_missing(inputs, poses, frames, partial);
  move_into_place(partial, directory, any_masked(inputs, frames));
}

}  // namespace raywalk::calibrate
