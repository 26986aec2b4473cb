#include "calibrate/rectify/before_list.h"

#include <string>
#include <vector>

#include "calibrate/base/frame_masks.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"

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

}  // namespace

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
                    .mask = mask_file(panoramas, static_cast<int>(i), mask, out)});
  }
  write_file_atomically(out / "before.csv", frame_list_text(rows));
}

}  // namespace raywalk::calibrate
