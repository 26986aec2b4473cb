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

#include <opencv2/core/mat.hpp>

namespace raywalk {

// What FSIM averages, of every pixel of the images averaged down: CV_64FC1 of their size.
struct FeatureSimilarity {
  cv::Mat weighted{};  // S_P S_G max(P_a, P_b)
  cv::Mat weight{};    // max(P_a, P_b)
};

// Images are CV_8UC3 in BGR order, of equal size, at least 8x8; throws Error otherwise.
FeatureSimilarity feature_similarity(const cv::Mat& a, const cv::Mat& b);

// Of the images, or of the part of them that is given.
double fsim(const FeatureSimilarity& features);

// In (0, 1], 1 for equal images; also 1 where neither image has any feature to compare (two
// constant images: FSIM does not see brightness). Symmetric. Throws Error as feature_similarity
// does.
double fsim(const cv::Mat& a, const cv::Mat& b);

}  // namespace raywalk
