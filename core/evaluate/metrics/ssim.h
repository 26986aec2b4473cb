// Structural similarity (Wang, Bovik, Sheikh, Simoncelli, IEEE Transactions on Image Processing
// 13(4), 2004) on luma, in the block form of ffmpeg's ssim filter.
//
// Over every 8x8 block, at steps of 4 pixels, with means m, unbiased variances v and covariance c:
//   SSIM = (2 m_a m_b + C1) (2 c + C2) / ((m_a^2 + m_b^2 + C1) (v_a + v_b + C2)),
// and the value is the mean over the blocks. Pixels beyond the last multiple of 4 are ignored, as
// in ffmpeg. Two things differ from the 2004 paper: the flat 8x8 window in place of an 11x11
// Gaussian, and C1, which ffmpeg sets to (0.01 * 255)^2 / 64. C1 matters for dark flat images: 0
// against 1 is 0.0922 in ffmpeg, 0.867 with the paper's C1; bright images are hardly affected.
//
// Agreement with ffmpeg, both fed the gray8 planes of luma.h: within 1e-6. Blocks here are in
// double, ffmpeg's in float, and ffmpeg prints 6 decimals. ffmpeg's SSE2 code (seen in 5.1) is
// wrong where a row has 4 n + 1 blocks, that is at widths of 8 to 11 above a multiple of 16 (it
// takes another block for the last one of a row): compare there with `-cpuflags 0`.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// In [-1, 1], 1 for equal luma. Symmetric. Images are CV_8UC3 in BGR order, of equal size, at least
// 8x8; throws Error otherwise.
double ssim(const cv::Mat& a, const cv::Mat& b);

}  // namespace raywalk
