#include "calibrate/rectify/compared_light.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/number_bytes.h"
#include "calibrate/rectify/compared_panorama.h"
#include "calibrate/rectify/held_out_light.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

// The first number of a file of patches; another where its form changes.
constexpr std::uint64_t kForm = 0x5261'794c'6967'6801;

// By frame; those that are not of `frames` stay empty.
std::vector<ComparedPanorama> compared_panoramas(const CaptureSet& panoramas,
                                                 const FramePoses& poses, const cv::Mat& mask,
                                                 const std::vector<int>& frames) {
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

std::vector<int> posed_frames(const FramePoses& poses) {
  std::vector<int> frames;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

LightComparison::LightComparison(const CaptureSet& panoramas, const FramePoses& poses,
                                 const cv::Mat& mask)
    : set_(panoramas), poses_(poses), mask_(mask), links_(links_of(panoramas, poses)) {
  of_stations_ = links_.size();
  for (const FrameLink link : held_out_links(panoramas, poses)) links_.push_back(link);
}

std::vector<LinkPatches> LightComparison::compare(IndexRange range) const {
  std::vector<LinkPatches> links;
  std::vector<int> frames;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    links.push_back({.link = links_[i], .patches = {}});
    frames.insert(frames.end(), {links_[i].from, links_[i].to});
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  const std::vector<ComparedPanorama> pictures = compared_panoramas(set_, poses_, mask_, frames);
  Progress progress("Comparing exposures", static_cast<std::int64_t>(links.size()), "pairs");
  parallel_for(0, static_cast<int>(links.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      auto& [link, patches] = links[static_cast<std::size_t>(i)];
      patches = match_patches(pictures[static_cast<std::size_t>(link.from)],
                              pictures[static_cast<std::size_t>(link.to)]);
      progress.advance();
    }
  });
  return links;
}

ExposureResult LightComparison::exposures(const std::vector<LinkPatches>& links) const {
  const auto count = static_cast<int>(set_.frames.size());
  const auto stations = static_cast<int>(set_.stations());
  const std::vector<PictureLine> lines = posed_lines(set_, poses_);
  const Eigen::Vector3d centre_m =
      middle_m({poses_.begin(), poses_.begin() + static_cast<std::ptrdiff_t>(stations)});
  ExposureResult result =
      measure_exposures(std::span(links).first(of_stations_), stations, lines, centre_m);
  if (count > stations) add_held_out_light(links, count, lines, centre_m, &result);
  return result;
}

std::string bytes_of(const std::vector<LinkPatches>& links) {
  NumberWriter writer;
  writer.number(kForm);
  writer.size(links.size());
  for (const LinkPatches& of_link : links) {
    writer.number(std::int32_t{of_link.link.from});
    writer.number(std::int32_t{of_link.link.to});
    writer.size(of_link.patches.size());
    for (const MatchedPatch& patch : of_link.patches) {
      writer.matrix(patch.point_m);
      writer.matrix(patch.log_ratio);
      writer.number(patch.error);
      writer.number(patch.parallax);
      writer.number(patch.ahead);
      writer.matrix(patch.seen_from);
      writer.matrix(patch.seen_to);
    }
  }
  return writer.take();
}

std::vector<LinkPatches> read_link_patches(std::string_view bytes, std::size_t frames) {
  NumberReader reader(
      bytes,
      "the compared light of a block is damaged; remove blocks/rectify-light in the "
      "calibration and make its blocks again");
  if (reader.number<std::uint64_t>() != kForm) reader.fail();
  std::vector<LinkPatches> links;
  for (std::size_t left = reader.size(); left > 0; --left) {
    LinkPatches& of_link = links.emplace_back();
    of_link.link.from = reader.index(frames);
    of_link.link.to = reader.index(frames);
    for (std::size_t patches = reader.size(); patches > 0; --patches) {
      MatchedPatch& patch = of_link.patches.emplace_back();
      patch.point_m = reader.matrix<Eigen::Vector3d>();
      patch.log_ratio = reader.matrix<Eigen::Array3d>();
      patch.error = reader.number<double>();
      patch.parallax = reader.number<double>();
      patch.ahead = reader.number<double>();
      patch.seen_from = reader.matrix<Eigen::Vector3d>();
      patch.seen_to = reader.matrix<Eigen::Vector3d>();
    }
  }
  reader.end();
  return links;
}

}  // namespace raywalk::calibrate
