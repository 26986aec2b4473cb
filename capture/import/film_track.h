// Motion and sharpness of every frame of a film.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

struct FilmFrame {
  double time_s = 0.0;     // since the first frame
  double activity = 0.0;   // change since the frame before, grey levels; 0 for the first
  double sharpness = 0.0;  // variance of the picture's Laplacian
};

struct FilmTrack {
  std::vector<FilmFrame> frames;
  cv::Size size{};
};

// Mean absolute difference of two small grey pictures of the same size, in grey levels.
double activity_between(const cv::Mat& small_before, const cv::Mat& small_now);

// Variance of the Laplacian over the middle half of the rows of a picture (CV_8UC3); the upper and
// lower quarter of a panorama are stretched. Lower is more blurred. (J. L. Pech-Pacheco et al.,
// "Diatom autofocusing in brightfield microscopy", ICPR 2000.)
double sharpness_of(const cv::Mat& picture);

// Reads a film from start to end with one frame in memory at a time. Throws Error as VideoReader
// does; Interrupted.
FilmTrack track_film(const std::filesystem::path& film);

// One flag per frame: clearly less sharp than the frames within half a second around it.
std::vector<bool> blurred_frames(const FilmTrack& track);

}  // namespace raywalk::capture
