#include "capture/import/video_reader.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "core/base/error.h"

namespace raywalk::capture {

VideoReader::VideoReader(std::filesystem::path file) : file_(std::move(file)) {
  if (!std::filesystem::is_regular_file(file_)) {
    throw Error(fmt::format("{}: no such file", file_.string()));
  }
  // Naming the backend keeps OpenCV from taking the file for an image sequence or a camera.
  // FFmpeg's own messages name no file (-8: AV_LOG_QUIET).
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  if (!capture_.open(file_.string(), cv::CAP_FFMPEG)) {
    throw Error(fmt::format("{}: not a film that can be read", file_.string()));
  }
  const double rate_hz = capture_.get(cv::CAP_PROP_FPS);
  if (rate_hz > 0.0 && rate_hz < 1e4) frame_interval_s_ = 1.0 / rate_hz;
}

// OpenCV documents CAP_PROP_POS_MSEC as the position of the current frame. Containers without
// timestamps give 0 for all frames; their times follow from the frame rate.
double VideoReader::time_of_frame() {
  const double stated_s = 1e-3 * capture_.get(cv::CAP_PROP_POS_MSEC);
  if (frames_ == 0) first_s_ = stated_s;
  const double since_first_s = stated_s - first_s_;
  if (since_first_s > last_s_) return since_first_s;
  if (frame_interval_s_ <= 0.0) {
    throw Error(fmt::format("{}: frame {} has no timestamp, and the film has no frame rate",
                            file_.string(), frames_));
  }
  return last_s_ + frame_interval_s_;
}

bool VideoReader::next(DecodedFrame* frame) {
  if (!capture_.read(frame->picture) || frame->picture.empty()) {
    if (frames_ == 0) {
      throw Error(fmt::format("{}: no frame can be decoded", file_.string()));
    }
    return false;
  }
  if (frames_ == 0) size_ = frame->picture.size();
  if (frame->picture.size() != size_ || frame->picture.type() != CV_8UC3) {
    throw Error(fmt::format("{}: frame {} is {} x {} pixels, the first {} x {}; cut the film there",
                            file_.string(), frames_, frame->picture.cols, frame->picture.rows,
                            size_.width, size_.height));
  }
  last_s_ = time_of_frame();
  frame->time_s = last_s_;
  frame->number = frames_++;
  return true;
}

}  // namespace raywalk::capture
