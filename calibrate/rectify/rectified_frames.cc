#include "calibrate/rectify/rectified_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/rectify/held_out_light.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/sha256.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDirectory = "rectified";

std::vector<int> posed_frames(const FramePoses& poses) {
  std::vector<int> frames;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

// Fingerprint of everything that the pictures depend on.
std::string inputs_of(const CaptureSet& set, const FramePoses& poses,
                      const std::vector<LightGain>& gains, const cv::Mat& mask) {
  std::string inputs;
  for (const int index : posed_frames(poses)) {
    const auto i = static_cast<std::size_t>(index);
    const fs::path& file = set.frames[i].file;
    inputs += fmt::format("{} {} {}", set.frames[i].name, fs::absolute(file).string(),
                          stamp_of(file).text());
    for (const double element : poses[i]->world_from_camera.reshaped()) {
      inputs += fmt::format(" {:.17g}", element);
    }
    for (const double gain : gains[i]) inputs += fmt::format(" {:.17g}", gain);
    if (const auto& own = set.frames[i].mask) {
      inputs += fmt::format(" {} {}", fs::absolute(*own).string(), stamp_of(*own).text());
    }
    inputs += '\n';
  }
  if (!mask.empty()) inputs += sha256_of_pixels(mask);
  return sha256_hex(inputs);
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

// `mask` is that of all frames.
void write_mask(const CaptureSet& set, int index, const FramePose& pose, const cv::Mat& mask,
                const fs::path& file) {
  const cv::Mat rotated = rotate_mask(joint_mask(set, index, mask), pose.world_from_camera);
  if (cv::countNonZero(rotated) > 0) return write_image(file, rotated);
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(index)];
  throw Error(fmt::format(
      "{}: of what the mask of frame {} leaves, nothing remains after rotation; give it a mask "
      "that leaves more than single pixels",
      frame.where.empty() ? set.source.string() : frame.where, frame.name));
}

void write_frame(const CaptureSet& set, int index, const FramePose& pose, const LightGain& gain,
                 const cv::Mat& mask, const fs::path& directory) {
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(index)];
  const fs::path picture = directory / rectified_file(frame).filename();
  const fs::path masked = directory / "masks" / rectified_mask_file(frame).filename();
  if ((!mask.empty() || frame.mask) && !fs::exists(masked)) {
    write_mask(set, index, pose, mask, masked);
  }
  if (fs::exists(picture)) return;
  const cv::Mat panorama = read_panorama(frame.file);
  const LevelsUnderGain levels(gain);
  write_image(picture, rotate_panorama(panorama, pose.world_from_camera,
                                       [&levels](const cv::Vec3f& seen) { return levels(seen); }));
}

void move_into_place(const fs::path& partial, const fs::path& directory, bool masked) {
  fs::remove(partial / "inputs.txt");
  if (!masked) fs::remove(partial / "masks");
  fs::path old = directory;
  old += ".old";
  fs::remove_all(old);
  if (fs::exists(directory)) fs::rename(directory, old);
  fs::rename(partial, directory);
  fs::remove_all(old);
}

// By frame; those without a pose stay empty.
std::vector<ComparedPanorama> compared_panoramas(const CaptureSet& panoramas,
                                                 const FramePoses& poses, const cv::Mat& mask) {
  const std::vector<int> frames = posed_frames(poses);
  std::vector<ComparedPanorama> pictures(poses.size());
  Progress progress("Reading panoramas", static_cast<std::int64_t>(frames.size()), "frames");
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto frame = static_cast<std::size_t>(frames[static_cast<std::size_t>(i)]);
      const CaptureFrame& of = panoramas.frames[frame];
      pictures[frame] = ComparedPanorama(read_panorama(of.file),
                                         joint_mask(panoramas, static_cast<int>(frame), mask),
                                         of.mask.has_value(), *poses[frame]);
      progress.advance();
    }
  });
  return pictures;
}

std::vector<PictureLine> posed_lines(const CaptureSet& set, const FramePoses& poses) {
  std::vector<PictureLine> lines;
  for (const CaptureLine& line : set.lines) {
    PictureLine posed;
    for (const int frame : line.frames) {
      if (!poses[static_cast<std::size_t>(frame)]) continue;
      posed.pictures.push_back(frame);
      posed.along_m.push_back(set.rail_m(frame));
    }
    lines.push_back(std::move(posed));
  }
  return lines;
}

Eigen::Vector3d middle_m(const FramePoses& poses) {
  Eigen::Vector3d sum(0.0, 0.0, 0.0);
  const std::vector<int> frames = posed_frames(poses);
  for (const int frame : frames) sum += poses[static_cast<std::size_t>(frame)]->position_m;
  return sum / static_cast<double>(std::max<std::size_t>(1, frames.size()));
}

}  // namespace

ExposureResult compare_exposures(const CaptureSet& panoramas, const FramePoses& poses,
                                 const cv::Mat& mask) {
  const auto count = static_cast<int>(panoramas.frames.size());
  const auto stations = static_cast<int>(panoramas.stations());
  const std::vector<ComparedPanorama> pictures = compared_panoramas(panoramas, poses, mask);
  std::vector<LinkPatches> links;
  for (const FrameLink link : links_of(panoramas, poses)) links.push_back({.link = link});
  const std::size_t of_stations = links.size();
  for (const FrameLink link : held_out_links(panoramas, poses)) links.push_back({.link = link});
  Progress progress("Comparing exposures", static_cast<std::int64_t>(links.size()), "pairs");
  parallel_for(0, static_cast<int>(links.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      auto& [link, patches] = links[static_cast<std::size_t>(i)];
      patches = match_patches(pictures[static_cast<std::size_t>(link.from)],
                              pictures[static_cast<std::size_t>(link.to)]);
      progress.advance();
    }
  });
  const std::vector<PictureLine> lines = posed_lines(panoramas, poses);
  const Eigen::Vector3d centre_m =
      middle_m({poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(stations)});
  ExposureResult result =
      measure_exposures(std::span(links).first(of_stations), stations, lines, centre_m);
  if (count > stations) add_held_out_light(links, count, lines, centre_m, &result);
  return result;
}

fs::path rectified_file(const CaptureFrame& frame) {
  return fs::path(kDirectory) / (frame.name + ".png");
}

fs::path rectified_mask_file(const CaptureFrame& frame) {
  return fs::path(kDirectory) / "masks" / (frame.name + ".png");
}

void write_rectified_frames(const CaptureSet& panoramas, const FramePoses& poses,
                            const std::vector<LightGain>& gains, const cv::Mat& mask,
                            const fs::path& out) {
  const fs::path directory = out / kDirectory;
  fs::path partial = directory;
  partial += ".partial";
  prepare(partial, inputs_of(panoramas, poses, gains, mask));
  const std::vector<int> frames = posed_frames(poses);
  Progress progress("Rectifying", static_cast<std::int64_t>(frames.size()), "frames");
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto frame = static_cast<std::size_t>(frames[static_cast<std::size_t>(i)]);
      write_frame(panoramas, static_cast<int>(frame), *poses[frame], gains[frame], mask, partial);
      progress.advance();
    }
  });
  const bool masked = !mask.empty() || std::any_of(frames.begin(), frames.end(), [&](int frame) {
    return panoramas.frames[static_cast<std::size_t>(frame)].mask.has_value();
  });
  move_into_place(partial, directory, masked);
}

}  // namespace raywalk::calibrate
