#include "render/video/video_writer.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/output_folder.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

VideoShape even(const VideoShape& shape) {
  require_video_size(shape.size);
  return shape;
}

bool is_video_of_raywalk(const fs::path& file) {
  try {
    return read_video(file).by_raywalk;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

void require_writable_video(const fs::path& file, bool replace) {
  if (!replace) require_absent(file, "--video");
  std::error_code none;
  if (fs::exists(file, none) && !is_video_of_raywalk(file)) {
    throw Error(file.string() + " is not a video of Raywalk's, so --force does not replace it");
  }
  const AtomicFile probe(file);
}

void require_video_size(cv::Size size) {
  if (size.width % 2 == 0 && size.height % 2 == 0) return;
  throw UsageError(
      fmt::format("a video of {}x{} pixels is not possible: give --size with two even "
                  "numbers",
                  size.width, size.height));
}

VideoWriter::VideoWriter(const VideoSettings& settings, const VideoShape& shape,
                         std::optional<StereoMode> stereo, const fs::path& file)
    : target_(file),
      shape_(even(shape)),
      stereo_(stereo),
      video_(file),
      encoder_(settings, shape, video_.temporary_path(), file.string()) {}

void VideoWriter::finish() {
  encoder_.finish();
  if (stereo_) set_spherical(video_.temporary_path(), *stereo_, target_.string());
  const VideoFacts written = read_video(video_.temporary_path());
  const cv::Size size = shape_.size;
  if (written.frames != shape_.frames || written.width != size.width ||
      written.height != size.height || written.stereo != stereo_) {
    throw Error(fmt::format(
        "cannot write {}: read again, the video has {} frames of {}x{}, not {} of {}x{}; is the "
        "disk full?",
        target_.string(), written.frames, written.width, written.height, shape_.frames, size.width,
        size.height));
  }
  video_.commit();
}

}  // namespace raywalk::render
