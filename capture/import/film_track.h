// The frames of a film in order, each with its time; motion and sharpness of every one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

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

struct FilmFrame {
  double time_s = 0.0;     // since the first frame
  double activity = 0.0;   // mean change since the frame before, grey levels; 0 for the first
  double sharpness = 0.0;  // variance of the picture's Laplacian; lower is more blurred
};

struct FilmTrack {
  std::vector<FilmFrame> frames;
  cv::Size size{};
};

// Reads a film from start to end with one frame in memory at a time. Throws Error as VideoReader
// does; Interrupted.
FilmTrack track_film(const std::filesystem::path& film);

// One flag per frame: clearly less sharp than the frames within half a second around it.
std::vector<bool> blurred_frames(const FilmTrack& track);

}  // namespace raywalk::capture
