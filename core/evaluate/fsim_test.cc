#include "core/evaluate/fsim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/evaluate/test_images.h"

namespace raywalk {
namespace {

// Every pixel as a square of 2 x 2.
cv::Mat doubled(const cv::Mat& image) {
  cv::Mat out;
  cv::resize(image, out, {}, 2.0, 2.0, cv::INTER_NEAREST);
  return out;
}

TEST(Fsim, IsOneForEqualImages) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(131, 77), cv::Size(1024, 512)}) {
    const cv::Mat image = textured_image(size);
    EXPECT_NEAR(fsim(image, image), 1.0, 1e-12) << size;
  }
}

TEST(Fsim, IsThatOfTheLuma) {
  const cv::Mat a = textured_image({256, 128}), b = noisy(a, 10.0);
  const auto grey = [](const cv::Mat& bgr) {
    cv::Mat luma, image;
    cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
    cv::cvtColor(luma, image, cv::COLOR_GRAY2BGR);
    return image;
  };
  EXPECT_NEAR(fsim(a, b), fsim(grey(a), grey(b)), 1e-3);
  EXPECT_GT(std::abs(fsim(a, b) - fsim(a, grey(a))), 1e-3);
}

TEST(Fsim, DoesNotSeeBrightness) {
  const cv::Mat image = adjusted(textured_image({256, 128}), 0.5, 20.0);
  EXPECT_NEAR(fsim(image, adjusted(image, 1.0, 60.0)), 1.0, 1e-9);
  const cv::Mat dark = flat_image({31, 17}, {0, 0, 0}), bright = flat_image({31, 17}, {200, 90, 9});
  EXPECT_NEAR(fsim(dark, bright), 1.0, 1e-9);
}

// Grey blocks with a fine pattern, in integers so that any program can reproduce them.
cv::Mat block_image(int shift, int contrast, int base, bool diagonal) {
  cv::Mat image(128, 256, CV_8UC3);
  for (int row = 0; row < image.rows; ++row) {
    for (int col = 0; col < image.cols; ++col) {
      const int block = (row / 16 + (col + shift) / 24) % 5;
      const int detail = diagonal ? (row * row + col) % 11 : row * col % 7;
      image.at<cv::Vec3b>(row, col) =
          cv::Vec3b::all(static_cast<std::uint8_t>(block * contrast + base + detail));
    }
  }
  return image;
}

// Tests every parameter of the filters. The expected value was computed independently, by a direct
// transcription of the published algorithm with its own Fourier transform. A difference of 8e-5 is
// known: there the noise estimate uses only the real part of the filters, which ignores the overlap
// of opposite directions.
TEST(Fsim, IsTheValueOfASeparateComputation) {
  EXPECT_NEAR(fsim(block_image(0, 50, 0, false), block_image(2, 40, 20, true)), 0.775065, 1.5e-4);
}

TEST(Fsim, FallsAsBlurGrows) {
  const cv::Mat image = textured_image({256, 128});
  double previous = 1.0;
  for (const double sigma_px : {0.6, 1.0, 2.0, 4.0, 8.0}) {
    const double value = fsim(image, blurred(image, sigma_px));
    EXPECT_LT(value, previous) << sigma_px;
    EXPECT_NEAR(value, fsim(blurred(image, sigma_px), image), 1e-12);
    EXPECT_GT(value, 0.0);
    previous = value;
  }
}

TEST(Fsim, StaysWithinItsRangeForUnrelatedImagesOfAnySize) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(8, 301), cv::Size(17, 9), cv::Size(131, 67),
                              cv::Size(900, 640), cv::Size(1500, 749)}) {
    const double value = fsim(textured_image(size), noisy(flat_image(size, {99, 99, 99}), 60.0));
    EXPECT_GT(value, 0.0) << size;
    EXPECT_LT(value, 0.9) << size;
  }
}

// The seam of a panorama is not a border: rotating both about the vertical changes nothing. The
// shifts are multiples of the reduction (2 at 1024x512, 3 at 1536x768).
TEST(Fsim, DoesNotDependOnWhereThePanoramaIsCut) {
  for (const cv::Size size : {cv::Size(256, 128), cv::Size(1024, 512), cv::Size(1536, 768)}) {
    const cv::Mat a = textured_image(size);
    const cv::Mat b = blurred(a, 3.0);
    EXPECT_NEAR(fsim(rolled(a, 96), rolled(b, 96)), fsim(a, b), 1e-9) << size;
  }
}

// FSIM reduces images to about 256 pixels: finer detail has no effect.
TEST(Fsim, AveragesLargeImagesDownFirst) {
  const cv::Mat small = textured_image({512, 256});
  const cv::Mat small_blurred = blurred(small, 2.0);
  EXPECT_NEAR(fsim(doubled(small), doubled(small_blurred)), fsim(small, small_blurred), 1e-9);
}

}  // namespace
}  // namespace raywalk
