// Phase congruency: how far the Fourier components of an image agree in phase at a pixel, whatever
// their strength. FSIM uses it as the weight of a pixel: high at steps, lines and corners, 0 in
// flat regions.
//
// Kovesi's measure (Image Features from Phase Congruency, Videre 1(3), 1999) with the settings of
// FSIM (Zhang, Zhang, Mou, Zhang, IEEE Transactions on Image Processing 20(8), 2011): log-Gabor
// filters at 4 scales and 4 orientations, shortest wavelength 6 pixels, factor 2 between scales.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// Computes phase congruency for images of one size. The filters are built once; const members may
// be called from several threads.
class PhaseCongruency {
 public:
  // At least 2x2 pixels.
  explicit PhaseCongruency(cv::Size size);

  // `grey` is CV_64FC1 of the size given, in 8-bit levels (0..255). Returns CV_64FC1 in [0, 1]. The
  // image is treated as periodic in both directions, as the Fourier transform does: true for the
  // longitude of a panorama, an assumption for its latitude. Throws Error for another size or type.
  cv::Mat operator()(const cv::Mat& grey) const;

 private:
  static constexpr int kScales = 4;
  static constexpr int kOrientations = 4;

  void add_orientation(const cv::Mat& spectrum, int orientation, cv::Mat* energy,
                       cv::Mat* amplitude) const;
  double noise_threshold(const cv::Mat& finest_response, int orientation) const;

  cv::Size size_;
  // Transfer functions, CV_64FC1 in the order of cv::dft; a filter is the product of one of each.
  std::array<cv::Mat, kScales> radial_;
  std::array<cv::Mat, kOrientations> angular_;
};

}  // namespace raywalk
