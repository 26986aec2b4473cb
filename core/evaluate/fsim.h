// Feature similarity, FSIM (Zhang, Zhang, Mou, Zhang: FSIM: A Feature Similarity Index for Image
// Quality Assessment, IEEE Transactions on Image Processing 20(8), 2011), on luma.
//
// With phase congruency P and Scharr gradient magnitude G of both images,
//   S_P = (2 P_a P_b + T1) / (P_a^2 + P_b^2 + T1),  T1 = 0.85,
//   S_G = (2 G_a G_b + T2) / (G_a^2 + G_b^2 + T2),  T2 = 160,
//   FSIM = sum(S_P S_G max(P_a, P_b)) / sum(max(P_a, P_b)),
// after both were averaged down by max(1, round(min(width, height) / 256)). The paper does not
// define the image border. Here columns wrap around, as longitude does, and the first and last row
// are repeated; the authors' program treats everything outside as black. With such gradients the
// value changed by +0.0016 and -0.0006 on the two pairs tried, both 256x128. Two smaller
// differences: frequencies of odd sizes are exact here, and the noise estimate is in closed form
// (1e-4 in the value).
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// In (0, 1], 1 for equal images; also 1 where neither image has any feature to compare (two
// constant images: FSIM does not see brightness). Symmetric. Images are CV_8UC3 in BGR order, of
// equal size, at least 8x8; throws Error otherwise.
double fsim(const cv::Mat& a, const cv::Mat& b);

// Phase congruency: how far the Fourier components of an image agree in phase at a pixel, whatever
// their strength. FSIM uses it as the weight of a pixel: high at steps, lines and corners, 0 in
// flat regions.
//
// Kovesi's measure (Image Features from Phase Congruency, Videre 1(3), 1999) with the settings of
// FSIM: log-Gabor filters at 4 scales and 4 orientations, shortest wavelength 6 pixels, factor 2
// between scales. The filters are built once for images of one size; const members may be called
// from several threads.
class PhaseCongruency {
 public:
  // At least 2x2 pixels.
  explicit PhaseCongruency(cv::Size size);

  // `grey` is CV_64FC1 of the size given, in 8-bit levels (0..255). Returns CV_64FC1 in [0, 1]. The
  // image is treated as periodic in both directions, as the Fourier transform does: true for the
  // longitude of a panorama, an assumption for its latitude.
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
