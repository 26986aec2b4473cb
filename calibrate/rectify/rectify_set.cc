#include "calibrate/rectify/rectify_set.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "calibrate/rectify/compared_light.h"
#include "calibrate/rectify/crossing_overlay.h"
#include "calibrate/rectify/rectified_frames.h"
#include "calibrate/rectify/rectify_report.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMasks = "before_masks";

// Relative to OUT if it is in there, else absolute.
std::string listed(const fs::path& file, const fs::path& out) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  const fs::path within = whole.lexically_relative(fs::absolute(out).lexically_normal());
  const bool outside = within.empty() || *within.begin() == "..";
  return outside ? whole.string() : within.generic_string();
}

// The file of a frame's mask joined with the common one; "" if nothing is masked.
std::string mask_file(const CaptureSet& set, int index, const cv::Mat& common,
                      const fs::path& out) {
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(index)];
  if (common.empty()) return frame.mask ? listed(*frame.mask, out) : "";
  if (!frame.mask) return (fs::path(kMasks) / "common.png").generic_string();
  const fs::path file = fs::path(kMasks) / (frame.name + ".own.png");
  write_image(out / file, joint_mask(set, index, common));
  return file.generic_string();
}

// Writes OUT/before.csv (file,x,y,z,yaw,pitch,roll[,mask],line): the panoramas of poses.csv as they
// are, at their poses in `start`. Only frames with a pose in `poses` are listed, so that both rooms
// have the same stations. Files in OUT are relative to it, others absolute. `mask` (CV_8UC1 of the
// panoramas' size in the camera's frame, 0 = masked; may be empty) is joined with the frames' own
// and written to OUT/before_masks, which is removed where nothing is masked in common. Throws Error
// if a mask cannot be read or a file cannot be written.
void write_before_list(const CaptureSet& panoramas, const FramePoses& start,
                       const FramePoses& poses, const cv::Mat& mask, const fs::path& out) {
  fs::remove_all(out / kMasks);
  if (!mask.empty()) {
    make_directories(out / kMasks);
    write_image(out / kMasks / "common.png", mask);
  }
  std::vector<ListedFrame> rows;
  for (std::size_t i = 0; i < panoramas.frames.size(); ++i) {
    const CaptureFrame& frame = panoramas.frames[i];
    if (!poses[i] || panoramas.is_validation(frame)) continue;
    rows.push_back({.file = listed(frame.file, out),
                    .position_m = start[i]->position_m,
                    .attitude = attitude_from_world_from_camera(start[i]->world_from_camera),
                    .mask = mask_file(panoramas, static_cast<int>(i), mask, out),
                    .line = panoramas.lines[static_cast<std::size_t>(frame.line)].id});
  }
  write_file_atomically(out / "before.csv", frame_list_text(rows));
}

// Rows of poses.csv, or of gt.csv.
std::vector<ListedFrame> rectified_rows(const CaptureSet& set, const FramePoses& poses, bool masked,
                                        bool validation) {
  std::vector<ListedFrame> rows;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    const CaptureFrame& frame = set.frames[i];
    if (!poses[i] || set.is_validation(frame) != validation) continue;
    rows.push_back(
        {.file = rectified_file(frame).generic_string(), .position_m = poses[i]->position_m});
    if (!validation) rows.back().line = set.lines[static_cast<std::size_t>(frame.line)].id;
    if (masked || frame.mask) rows.back().mask = rectified_mask_file(frame).generic_string();
  }
  return rows;
}

// What neither frame hides, each mask turned by the frame's pose; empty unless one of the frames
// has a mask of its own.
cv::Mat valid_in_both(const CaptureSet& set, const CrossingPair& pair, const FramePoses& poses,
                      const cv::Mat& common) {
  const auto own = [&](int i) { return set.frames[static_cast<std::size_t>(i)].mask.has_value(); };
  if (!own(pair.along_x) && !own(pair.along_z)) return {};
  const PanoramaSize size = set.frame;
  cv::Mat valid(size.height, size.width, CV_8UC1, cv::Scalar(255));
  for (const int i : {pair.along_x, pair.along_z}) {
    const cv::Mat mask = joint_mask(set, i, common);
    if (mask.empty()) continue;
    valid &= rotate_mask(mask, poses[static_cast<std::size_t>(i)]->world_from_camera);
  }
  return valid;
}

CrossingComparison compare_at(const CaptureSet& set, const LineCrossing& crossing,
                              const CrossingPair& pair, const FramePoses& poses,
                              const FramePoses& start, const cv::Mat& mask, const fs::path& out) {
  const auto frame_of = [&](int i) -> const CaptureFrame& {
    return set.frames[static_cast<std::size_t>(i)];
  };
  const auto before = [&](int i) {
    return rotate_panorama(read_panorama(frame_of(i).file),
                           start[static_cast<std::size_t>(i)]->world_from_camera);
  };
  const auto after = [&](int i) { return read_panorama(out / rectified_file(frame_of(i))); };
  const cv::Mat first = after(pair.along_x);
  const cv::Mat valid = valid_in_both(set, pair, poses, mask);
  const HorizonWindow window = most_textured_window(first, valid);
  const Overlay agreed = overlay_of(first, after(pair.along_z), window, valid);
  const Overlay captured = overlay_of(before(pair.along_x), before(pair.along_z), window,
                                      valid_in_both(set, pair, start, mask));
  const std::string name =
      fmt::format("{}_{}", set.lines[static_cast<std::size_t>(crossing.along_x)].id,
                  set.lines[static_cast<std::size_t>(crossing.along_z)].id);
  CrossingComparison comparison{.along_x = crossing.along_x,
                                .along_z = crossing.along_z,
                                .frame_x = frame_of(pair.along_x).name,
                                .frame_z = frame_of(pair.along_z).name,
                                .before = fs::path("crossings") / (name + "_before.png"),
                                .after = fs::path("crossings") / (name + "_after.png"),
                                .difference_before = captured.difference_levels,
                                .difference_after = agreed.difference_levels};
  write_image(out / comparison.before, captured.picture);
  write_image(out / comparison.after, agreed.picture);
  return comparison;
}

std::vector<CrossingComparison> compare_crossings(const CaptureSet& set, const FramePoses& poses,
                                                  const FramePoses& start, const cv::Mat& mask,
                                                  const fs::path& out) {
  make_directories(out / "crossings");
  std::vector<CrossingComparison> comparisons;
  for (const LineCrossing& crossing : crossings_of(set)) {
    throw_if_interrupted();
    const auto pair = nearest_pair(set, crossing, poses);
    if (pair) comparisons.push_back(compare_at(set, crossing, *pair, poses, start, mask, out));
  }
  return comparisons;
}

void require_pose(const CaptureSet& set, const FramePoses& poses) {
  for (std::size_t i = 0; i < set.stations(); ++i) {
    if (poses[i]) return;
  }
  throw Error("no frame has a pose; there is nothing to rectify");
}

void warn_of_left_out(const CaptureSet& set, const FramePoses& poses) {
  for (std::size_t i = set.stations(); i < set.frames.size(); ++i) {
    if (poses[i]) continue;
    spdlog::warn("{}: held-out frame {} has no pose and is left out of gt.csv", set.frames[i].where,
                 set.frames[i].name);
  }
}

void write_tables(const RectifyResult& result, const std::vector<ListedFrame>& rows,
                  const std::vector<ListedFrame>& truth, const fs::path& out) {
  write_file_atomically(out / "poses.csv", frame_list_text(rows));
  if (result.validation_frames > 0) {
    write_file_atomically(out / "gt.csv", frame_list_text(truth));
  } else {
    fs::remove(out / "gt.csv");
  }
}

}  // namespace

RectifyResult rectify_set(const CaptureSet& panoramas, const FramePoses& poses,
                          const RectifyOptions& options) {
  require_pose(panoramas, poses);
  make_directories(options.out);
  const cv::Mat mask = options.mask.value_or(cv::Mat());
  std::optional<ExposureResult> exposure;
  if (options.equalise_gain) exposure = compare_light(panoramas, poses, mask);
  RectifyResult result;
  result.gains = exposure
                     ? exposure->gains
                     : std::vector<LightGain>(panoramas.frames.size(), LightGain{1.0, 1.0, 1.0});
  write_rectified_frames(panoramas, poses, result.gains, mask, options.out, options.fisheye);
  const FramePoses start = options.start.empty() ? nominal_poses(panoramas) : options.start;
  result.exposure = std::move(exposure);
  if (result.exposure) spdlog::info("{}", exposure_summary(*result.exposure));
  const auto rows = rectified_rows(panoramas, poses, !mask.empty(), false);
  const auto truth = rectified_rows(panoramas, poses, !mask.empty(), true);
  result.frames = static_cast<int>(rows.size());
  result.validation_frames = static_cast<int>(truth.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) result.left_out.push_back(panoramas.frames[i].name);
  }
  warn_of_left_out(panoramas, poses);
  result.masks = mask_figures(panoramas, mask);
  result.line_tolerance_mm = line_tolerance_needed_mm(rows, options.tolerance);
  if (options.tolerance.same_station_m) {
    result.same_station_mm = *options.tolerance.same_station_m * 1e3;
  }
  write_tables(result, rows, truth, options.out);
  result.crossings = compare_crossings(panoramas, poses, start, mask, options.out);
  write_before_list(panoramas, start, poses, mask, options.out);
  write_rectify_report(panoramas, poses, result, options.out);
  return result;
}

std::optional<double> line_tolerance_needed_mm(const std::vector<ListedFrame>& frames,
                                               const GridTolerance& given) {
  std::vector<StationPose> stations;
  stations.reserve(frames.size());
  for (const ListedFrame& frame : frames) {
    stations.push_back({frame.file, frame.position_m, {}, frame.line});
  }
  for (const auto& off_line_m : {std::optional<double>(), given.off_line_m}) {
    try {
      find_grid(stations, {.off_line_m = off_line_m, .same_station_m = given.same_station_m});
      return 1000.0 * off_line_m.value_or(0.0);
    } catch (const Error&) {
      // Too far off for this tolerance.
    }
  }
  return std::nullopt;
}

}  // namespace raywalk::calibrate
