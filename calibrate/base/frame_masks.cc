#include "calibrate/base/frame_masks.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

cv::Mat read_usable_mask(const CaptureFrame& frame, PanoramaSize size) {
  const fs::path& file = *frame.mask;
  std::error_code error;
  if (!fs::exists(file, error)) {
    throw Error(fmt::format("{}: the mask {} does not exist; make it or leave the column empty",
                            frame.where, file.string()));
  }
  cv::Mat mask;
  try {
    if (file != frame.file) require_mask(file, size);
    mask = read_mask(file, size);
  } catch (const Error& unusable) {
    throw Error(fmt::format("{}: {}", frame.where, unusable.what()));
  }
  if (cv::countNonZero(mask) == 0) {
    throw Error(fmt::format(
        "{}: {} masks every pixel (black is masked, white valid); remove the row, or correct the "
        "mask",
        frame.where, file.string()));
  }
  return mask;
}

// Of each list in which some frames have masks and others have none.
void warn_of_missing(const CaptureSet& set) {
  for (const bool held_out : {false, true}) {
    std::size_t frames = 0;
    std::vector<std::string> without;  // rows
    for (const CaptureFrame& frame : set.frames) {
      if (frame.held_out() != held_out) continue;
      ++frames;
      if (!frame.mask) without.push_back(frame.where);
    }
    if (without.empty() || without.size() == frames) continue;
    spdlog::warn("{} of {} frames have no mask, the first at {}: all their pixels are used",
                 without.size(), frames, without.front());
  }
}

}  // namespace

void require_usable_masks(const CaptureSet& set) {
  std::map<fs::path, const CaptureFrame*> first_with;  // many frames may share a mask
  for (const CaptureFrame& frame : set.frames) {
    if (frame.mask) first_with.emplace(*frame.mask, &frame);
  }
  if (first_with.empty()) return;
  std::vector<const CaptureFrame*> frames;
  frames.reserve(first_with.size());
  for (const auto& [file, frame] : first_with) frames.push_back(frame);
  Progress progress("checking masks", std::ssize(frames), "masks");
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      read_usable_mask(*frames[static_cast<std::size_t>(i)], set.frame);
      progress.advance();
    }
  });
  warn_of_missing(set);
}

bool any_masks(const CaptureSet& set) {
  return std::any_of(set.frames.begin(), set.frames.end(),
                     [](const CaptureFrame& frame) { return frame.mask.has_value(); });
}

cv::Mat own_mask(const CaptureFrame& frame, PanoramaSize size) {
  return frame.mask ? read_usable_mask(frame, size) : cv::Mat();
}

cv::Mat joint_mask(const CaptureSet& set, int frame, const cv::Mat& common) {
  const CaptureFrame& of = set.frames[static_cast<std::size_t>(frame)];
  cv::Mat mask = own_mask(of, set.frame);
  if (mask.empty() || common.empty()) return mask.empty() ? common : mask;
  mask &= common;
  if (cv::countNonZero(mask) > 0) return mask;
  throw Error(fmt::format(
      "{}: {} and the mask below the camera together hide every pixel of frame {}; remove the row, "
      "or make one of the masks smaller",
      of.where, of.mask->string(), of.name));
}

MaskFigures mask_figures(const CaptureSet& panoramas, const cv::Mat& common) {
  std::vector<int> masked;
  for (std::size_t i = 0; i < panoramas.frames.size(); ++i) {
    if (panoramas.frames[i].mask) masked.push_back(static_cast<int>(i));
  }
  std::vector<double> shares(masked.size());
  parallel_for(0, static_cast<int>(masked.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto at = static_cast<std::size_t>(i);
      shares[at] = masked_share(joint_mask(panoramas, masked[at], common));
    }
  });
  MaskFigures figures{.frames = static_cast<int>(masked.size())};
  for (const double share : shares) figures.share += share / static_cast<double>(shares.size());
  return figures;
}

}  // namespace raywalk::calibrate
