// Encodes frames with ffmpeg, which is run as a program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "core/base/child_process.h"
#include "render/video/video_codec.h"

namespace raywalk::render {

// Where ffmpeg is. Throws Error naming the package where it is not installed.
std::filesystem::path find_ffmpeg();

struct VideoShape {
  cv::Size size{};  // of all frames
  std::int64_t frames = 0;
};

// One video being encoded to a file that nobody sees yet. The destructor ends ffmpeg.
class VideoEncoder {
 public:
  // `file` must not exist; its extension is video_extension(). `name`
  // is what messages call the video. Throws Error: no ffmpeg.
  VideoEncoder(const VideoSettings& settings, const VideoShape& shape,
               const std::filesystem::path& file, const std::string& name);
  ~VideoEncoder();
  VideoEncoder(const VideoEncoder&) = delete;
  VideoEncoder& operator=(const VideoEncoder&) = delete;

  // Adds a frame, CV_8UC3 in BGR order. Throws Error with ffmpeg's last words where it has ended;
  // Interrupted on Ctrl-C.
  void add(const cv::Mat& frame);
  // Waits until the file is written. Throws as add() does.
  void finish();

 private:
  class Log;
  [[noreturn]] void throw_failure();

  std::string name_;
  cv::Size size_;
  std::unique_ptr<Log> log_;
  std::unique_ptr<ChildProcess> ffmpeg_;
  std::int64_t frames_ = 0;
};

}  // namespace raywalk::render
