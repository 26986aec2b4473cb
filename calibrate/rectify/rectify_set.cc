#include "calibrate/rectify/rectify_set.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "calibrate/rectify/intersection_overlay.h"
#include "calibrate/rectify/rectified_frames.h"
#include "calibrate/rectify/rectify_report.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Not "masks", which a capture that is calibrated in its own folder may have.
constexpr const char* kMasks = "joined_masks";

// Relative to OUT if the two are in the same folder, as a capture and its calibration are, which
// are moved together; else absolute.
std::string listed(const fs::path& file, const fs::path& out) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  const fs::path from = (fs::absolute(out) / "").lexically_normal();
  const fs::path within = whole.lexically_relative(from.parent_path().parent_path());
  const bool outside = within.empty() || *within.begin() == "..";
  return outside ? whole.string() : whole.lexically_relative(from).generic_string();
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

// Writes the masks of all frames to OUT/joined_masks, which is removed where nothing is masked in
// common. By frame: the file of its mask, "" if nothing is masked.
std::vector<std::string> write_masks(const CaptureSet& set, const cv::Mat& common,
                                     const fs::path& out) {
  fs::remove_all(out / kMasks);
  if (!common.empty()) {
    make_directories(out / kMasks);
    write_image(out / kMasks / "common.png", common);
  }
  std::vector<std::string> files;
  files.reserve(set.frames.size());
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    files.push_back(mask_file(set, static_cast<int>(i), common, out));
  }
  return files;
}

// The lists of the frames with a pose: that of the stations, and that of true views.
struct FrameLists {
  std::vector<ListedFrame> stations{};
  std::vector<ListedFrame> validation{};
};

// `row_of` gives a frame's row without its line.
template <typename RowOf>
FrameLists lists_of(const CaptureSet& set, const FramePoses& poses, const RowOf& row_of) {
  FrameLists lists;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    const CaptureFrame& frame = set.frames[i];
    if (!poses[i]) continue;
    if (set.is_validation(frame)) {
      lists.validation.push_back(row_of(i));
    } else {
      lists.stations.push_back(row_of(i));
      lists.stations.back().line = set.lines[static_cast<std::size_t>(frame.line)].id;
    }
  }
  return lists;
}

// What neither frame hides, each mask turned by the frame's pose; empty unless one of the frames
// has a mask of its own.
cv::Mat valid_in_both(const CaptureSet& set, const IntersectionPair& pair, const FramePoses& poses,
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

IntersectionComparison compare_at(const CaptureSet& set, const LineIntersection& intersection,
                                  const IntersectionPair& pair, const FramePoses& poses,
                                  const FramePoses& start, const cv::Mat& mask,
                                  const fs::path& out) {
  const auto frame_of = [&](int i) -> const CaptureFrame& {
    return set.frames[static_cast<std::size_t>(i)];
  };
  const auto at = [&](int i, const FramePoses& by) {
    return rotate_panorama(read_panorama(frame_of(i).file),
                           by[static_cast<std::size_t>(i)]->world_from_camera);
  };
  const cv::Mat first = at(pair.along_x, poses);
  const cv::Mat valid = valid_in_both(set, pair, poses, mask);
  const HorizonWindow window = most_textured_window(first, valid);
  const Overlay agreed = overlay_of(first, at(pair.along_z, poses), window, valid);
  const Overlay captured = overlay_of(at(pair.along_x, start), at(pair.along_z, start), window,
                                      valid_in_both(set, pair, start, mask));
  const std::string name =
      fmt::format("{}_{}", set.lines[static_cast<std::size_t>(intersection.along_x)].id,
                  set.lines[static_cast<std::size_t>(intersection.along_z)].id);
  IntersectionComparison comparison{.along_x = intersection.along_x,
                                    .along_z = intersection.along_z,
                                    .frame_x = frame_of(pair.along_x).name,
                                    .frame_z = frame_of(pair.along_z).name,
                                    .before = fs::path("intersections") / (name + "_before.png"),
                                    .after = fs::path("intersections") / (name + "_after.png"),
                                    .difference_before = captured.difference_levels,
                                    .difference_after = agreed.difference_levels};
  write_image(out / comparison.before, captured.picture);
  write_image(out / comparison.after, agreed.picture);
  return comparison;
}

std::vector<IntersectionComparison> compare_intersections(const CaptureSet& set,
                                                          const FramePoses& poses,
                                                          const FramePoses& start,
                                                          const cv::Mat& mask,
                                                          const fs::path& out) {
  make_directories(out / "intersections");
  std::vector<IntersectionComparison> comparisons;
  for (const LineIntersection& intersection : intersections_of(set)) {
    throw_if_interrupted();
    const auto pair = nearest_pair(set, intersection, poses);
    if (pair) comparisons.push_back(compare_at(set, intersection, *pair, poses, start, mask, out));
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

void write_tables(const FrameLists& lists, const FrameLists& before, const fs::path& out) {
  write_file_atomically(out / "poses.csv", frame_list_text(lists.stations));
  write_file_atomically(out / "before.csv", frame_list_text(before.stations));
  if (!lists.validation.empty()) {
    write_file_atomically(out / "gt.csv", frame_list_text(lists.validation));
  } else {
    fs::remove(out / "gt.csv");
  }
}

// The --line-tolerance-mm with which raywalk-build-lf pack takes these frames: 0 if its default is
// sufficient, else that with which the capture's lines were found (`given`); nullopt if neither is.
// Its --same-station-mm is that of `given`.
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

}  // namespace

RectifyResult rectify_set(const CaptureSet& panoramas, const FramePoses& poses,
                          const RectifyOptions& options) {
  require_pose(panoramas, poses);
  const fs::path& out = options.out;
  make_directories(out);
  const cv::Mat mask = options.mask.value_or(cv::Mat());
  const std::vector<std::string> masks = write_masks(panoramas, mask, out);
  const auto as_captured = [&](std::size_t i, const FramePoses& by) {
    return ListedFrame{
        .file = listed(panoramas.frames[i].file, out),
        .position_m = by[i]->position_m,
        .attitude = attitude_from_world_from_camera(by[i]->world_from_camera),
        .mask = masks[i],
    };
  };
  const auto rectified = [&](std::size_t i) {
    const CaptureFrame& frame = panoramas.frames[i];
    return ListedFrame{
        .file = rectified_file(frame).generic_string(),
        .position_m = poses[i]->position_m,
        .mask = masks[i].empty() ? "" : rectified_mask_file(frame).generic_string(),
    };
  };
  if (options.fisheye) write_rectified_frames(*options.fisheye, panoramas, poses, mask, out);
  const auto row_of = [&](std::size_t i) {
    return options.fisheye ? rectified(i) : as_captured(i, poses);
  };
  const FramePoses start = options.start.empty() ? nominal_poses(panoramas) : options.start;
  const FrameLists lists = lists_of(panoramas, poses, row_of);
  RectifyResult result;
  result.frames = static_cast<int>(lists.stations.size());
  result.validation_frames = static_cast<int>(lists.validation.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    result.files.push_back(poses[i] ? row_of(i).file : "");
    if (!poses[i]) result.left_out.push_back(panoramas.frames[i].name);
  }
  warn_of_left_out(panoramas, poses);
  result.masks = mask_figures(panoramas, mask);
  result.line_tolerance_mm = line_tolerance_needed_mm(lists.stations, options.tolerance);
  if (options.tolerance.same_station_m) {
    result.same_station_mm = *options.tolerance.same_station_m * 1e3;
  }
  const auto before = [&](std::size_t i) { return as_captured(i, start); };
  write_tables(lists, lists_of(panoramas, poses, before), out);
  result.intersections = compare_intersections(panoramas, poses, start, mask, out);
  write_rectify_report(panoramas, poses, result, out);
  return result;
}

}  // namespace raywalk::calibrate
