// Scores of an image against another: PSNR, WS-PSNR, SSIM, and at silhouettes (FSIM:
// fsim.h).
//
// Images are CV_8UC3 of equal size. A mask is empty (every pixel counts) or CV_8UC1 of the images'
// size; pixels where it is not 0 count. All functions throw Error otherwise, for empty images, and
// for a mask that selects no pixel.
#pragma once

#include <limits>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// PSNR of identical images is infinite, which JSON cannot represent and a mean cannot use: scores
// are clamped to this. An 8-bit image that differs at all is rarely above 90 dB.
inline constexpr double kMaxPsnrDb = 100.0;

// Throws Error unless both images are CV_8UC3, of the same size, and at least min_side pixels wide
// and high.
void require_image_pair(const cv::Mat& a, const cv::Mat& b, int min_side);

// Mean of (a - b)^2 over all channels of the pixels that count; in squared 8-bit levels, 0..65025.
// Columns are selected by passing a.colRange(...).
double mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

// 10 log10(255^2 / mean_squared_error) in dB; +infinity for an error of 0.
double psnr_db(double mean_squared_error);

// The PSNR of two images in dB; +infinity for identical images, 0 at worst. All channels have the
// same weight: this is the `average` of ffmpeg's psnr filter for RGB input.
double psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

// WS-PSNR in dB (Sun, Lu, Yu: Weighted-to-Spherically-Uniform Quality Evaluation for
// Omnidirectional Video, IEEE Signal Processing Letters 24(9), 2017): as psnr_db, with every row
// weighted by cos(phi) at its pixel centres, the solid angle its pixels cover. The images are whole
// panoramas.
double ws_psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

// Structural similarity (Wang, Bovik, Sheikh, Simoncelli, IEEE Transactions on Image Processing
// 13(4), 2004), in the block form of ffmpeg's ssim filter, on BT.601 luma over the full range
// (Y = 0.299 R + 0.587 G + 0.114 B, ffmpeg's gray8) rounded to 8 bits. In [-1, 1], 1 for equal
// luma; symmetric. Images are in BGR order, at least 8 x 8.
//
// Over every 8x8 block, at steps of 4 pixels, with means m, unbiased variances v and covariance c:
//   SSIM = (2 m_a m_b + C1) (2 c + C2) / ((m_a^2 + m_b^2 + C1) (v_a + v_b + C2)),
// and the value is the mean over the blocks. Pixels beyond the last multiple of 4 are ignored, as
// in ffmpeg. Two things differ from the 2004 paper: the flat 8x8 window in place of an 11x11
// Gaussian, and C1, which ffmpeg sets to (0.01 * 255)^2 / 64. C1 matters for dark flat images: 0
// against 1 is 0.0922 in ffmpeg, 0.867 with the paper's C1; bright images are hardly affected.
//
// Agreement with ffmpeg: within 1e-6. Blocks here are in double, ffmpeg's in float, and ffmpeg
// prints 6 decimals. ffmpeg's SSE2 code (seen in 5.1) is wrong where a row has 4 n + 1 blocks, that
// is at widths of 8 to 11 above a multiple of 16 (it takes another block for the last one of a
// row): compare there with `-cpuflags 0`.
double ssim(const cv::Mat& a, const cv::Mat& b);

// How clean a view is at silhouettes, where near things end before far ones: there views on
// distances that are not exact tear, and leave specks. NaN: not measured.
struct SilhouetteScores {
  // Of the pixels within 2 of a true silhouette, and of the others: at most kMaxPsnrDb; NaN where
  // there are none.
  double near_psnr_db = std::numeric_limits<double>::quiet_NaN();
  double elsewhere_psnr_db = std::numeric_limits<double>::quiet_NaN();
  double near_share = std::numeric_limits<double>::quiet_NaN();  // of the pixels
  double specks_per_mpx = std::numeric_limits<double>::quiet_NaN();
};

// 255 within 2 pixels (5 x 5) of a silhouette, else 0. A silhouette is between two pixels, side by
// side or one above the other, whose distances have a ratio above 1.15; both are on it. Columns
// wrap around. `distances_mm` is a true distance map, CV_16UC1 in millimetres; 0, no surface,
// counts as 65535, the farthest. Throws Error for another type.
cv::Mat near_silhouettes(const cv::Mat& distances_mm);

// Of a panorama against its truth, CV_8UC3 of the size of `distances_mm`. A speck is a pixel of the
// view that differs by over 32 levels from the median of the 3 x 3 pixels around it and by over 48
// from the truth, each in some channel, where the truth differs by less than 16 from its own median
// in every channel. Pixels where `mask` (CV_8UC1, or empty) is 0 do not count. Throws Error where
// type or size is another, or the mask leaves no pixel.
SilhouetteScores score_silhouettes(const cv::Mat& view, const cv::Mat& truth,
                                   const cv::Mat& distances_mm, const cv::Mat& mask = cv::Mat());

}  // namespace raywalk
