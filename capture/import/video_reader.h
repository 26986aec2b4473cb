// Reads the frames of a film in order, each with its time.
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
  // Throws Error naming the file if it is missing or not a film.
  explicit VideoReader(std::filesystem::path file);

  // Returns false at the end. Throws Error if the first frame cannot be decoded, a frame has no
  // time, or a frame differs in size from the first.
  bool next(DecodedFrame* frame);

 private:
  double time_of_frame();

  std::filesystem::path file_;
  cv::VideoCapture capture_;
  double frame_interval_s_ = 0.0;  // 0 if the film has no frame rate
  double first_s_ = 0.0;
  double last_s_ = -1.0;
  std::size_t frames_ = 0;
  cv::Size size_{};
};

}  // namespace raywalk::capture
