// What the frames of a film show of the carriage's motion and of their own sharpness.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

struct FilmFrame {
  double time_s = 0.0;     // since the first frame
  double activity = 0.0;   // how much the picture changed since the frame before; 0 for the first
  double sharpness = 0.0;  // variance of the picture's Laplacian
};

struct FilmTrack {
  std::vector<FilmFrame> frames;
  cv::Size size{};
};

// Mean absolute difference of two small grey pictures of one size, in grey levels.
double activity_between(const cv::Mat& small_before, const cv::Mat& small_now);

// Variance of the Laplacian over the middle rows of a picture (CV_8UC3): blur flattens edges. The
// upper and lower quarter of a panorama, which are stretched, do not count. (J. L. Pech-Pacheco et
// al., "Diatom autofocusing in brightfield microscopy", ICPR 2000.)
double sharpness_of(const cv::Mat& picture);

// Reads a film from start to end; keeps one frame at a time in memory. Throws Error as VideoReader
// does; Interrupted.
FilmTrack track_film(const std::filesystem::path& film);

// Marks the frames that are clearly less sharp than their neighbours within half a second.
std::vector<bool> blurred_frames(const FilmTrack& track);

}  // namespace raywalk::capture
