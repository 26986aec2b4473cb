// Writes a video: frames in, a complete file out, or none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/files/atomic_output.h"
#include "render/video/video_encoder.h"
#include "render/video/video_file.h"

namespace raywalk::render {

// Throws Error where a video cannot be written there: something is there already and `replace` does
// not allow it, or it is not a video of Raywalk's; the folder is not writable.
void require_writable_video(const std::filesystem::path& file, bool replace);

// Throws UsageError for frames of an odd width or height.
void require_video_size(cv::Size size);

class VideoWriter {
 public:
  // `stereo`: the video is a panorama of the whole sphere and says so; without it, it is flat.
  // `shape` is that of the frames; both sides are even. Throws UsageError, Error as VideoEncoder
  // does.
  VideoWriter(const VideoSettings& settings, const VideoShape& shape,
              std::optional<StereoMode> stereo, const std::filesystem::path& file);

  // As VideoEncoder::add().
  void add(const cv::Mat& frame) { encoder_.add(frame); }
  // Completes the video, which has to have all of its frames, reads it again to see that every
  // frame and what it says of itself is there, and gives it its name. Throws Error, Interrupted;
  // then nothing is left.
  void finish();

 private:
  std::filesystem::path target_;
  VideoShape shape_;
  std::optional<StereoMode> stereo_;
  AtomicFile video_;
  VideoEncoder encoder_;
};

}  // namespace raywalk::render
