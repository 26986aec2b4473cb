// The frames of a film, in order, each with its time in the film.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>

namespace raywalk::capture {

struct DecodedFrame {
  std::size_t number = 0;  // from 0
  double time_s = 0.0;     // since the first frame; ascending
  cv::Mat picture;         // CV_8UC3, BGR
};

// Decodes a film from its start with OpenCV's VideoCapture.
class VideoReader {
 public:
  // Throws Error naming the file: missing, no film, no frame that can be decoded.
  explicit VideoReader(std::filesystem::path file);

  // Whether there was another frame. Throws Error where a frame has another size than the first.
  bool next(DecodedFrame* frame);

 private:
  double time_of_frame();

  std::filesystem::path file_;
  cv::VideoCapture capture_;
  double frame_interval_s_ = 0.0;  // 0 where the film does not say
  double first_s_ = 0.0;
  double last_s_ = -1.0;
  std::size_t frames_ = 0;
  cv::Size size_{};
};

}  // namespace raywalk::capture
