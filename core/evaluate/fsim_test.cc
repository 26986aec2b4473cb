#include "core/evaluate/fsim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/evaluate/test_images.h"

namespace raywalk {
namespace {

// One channel, as doubles.
cv::Mat levels(const cv::Mat& bgr) {
  cv::Mat grey, exact;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(exact, CV_64F);
  return exact;
}

constexpr int kStripe = 16;

// Upright stripes, alternately of level `base` and of `height` above it.
cv::Mat striped_image(int base, int height) {
  cv::Mat image = flat_image({256, 128}, cv::Scalar::all(base));
  for (int col = kStripe; col < image.cols; col += 2 * kStripe) {
    image.colRange(col, col + kStripe).setTo(cv::Scalar::all(base + height));
  }
  return image;
}

// Columns beside an edge between two stripes, the only ones with a nonzero gradient.
bool is_at_edge(int col) { return col % kStripe == 0 || col % kStripe == kStripe - 1; }

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

TEST(Fsim, IsSymmetric) {
  const cv::Mat a = textured_image({256, 128});
  const cv::Mat b = blurred(noisy(a, 8.0), 1.0);
  EXPECT_NEAR(fsim(a, b), fsim(b, a), 1e-12);
}

TEST(Fsim, DoesNotSeeBrightness) {
  const cv::Mat image = adjusted(textured_image({256, 128}), 0.5, 20.0);
  EXPECT_NEAR(fsim(image, adjusted(image, 1.0, 60.0)), 1.0, 1e-9);
}

// Phase congruency does not depend on contrast, so that FSIM reduces to the gradients. They are 0
// except in the two columns beside each edge, where a Scharr difference over an edge of height h is
// h:
//   FSIM = 1 - (share of the weight in those columns) (1 - (2 h g + 160) / (h^2 + g^2 + 160)).
TEST(Fsim, ReducesToGradientSimilarityWhereOnlyTheContrastDiffers) {
  constexpr int kHeight = 40;
  for (const int other_height : {20, 60, 160}) {
    const cv::Mat a = striped_image(30, kHeight);
    const cv::Mat b = striped_image(30, other_height);
    const cv::Mat weights = PhaseCongruency(a.size())(levels(a));
    double edge_weight = 0.0;
    for (int col = 0; col < a.cols; ++col) {
      if (is_at_edge(col)) edge_weight += cv::sum(weights.col(col))[0];
    }
    const double share = edge_weight / cv::sum(weights)[0];
    const double edge_similarity = (2.0 * kHeight * other_height + 160.0) /
                                   (kHeight * kHeight + other_height * other_height + 160.0);
    ASSERT_GT(share, 0.1);
    EXPECT_NEAR(fsim(a, b), 1.0 - share * (1.0 - edge_similarity), 1e-4) << other_height;
  }
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

constexpr int kStep = 64;

// 0 left of column 64 and from column 192 on, `height` between. The steps pass through the middle
// of a pixel (which has half the height), where all odd-symmetric components peak together.
cv::Mat step_image(double height, double base = 0.0) {
  cv::Mat image(128, 256, CV_64FC1, cv::Scalar(base));
  image.colRange(kStep, 193).setTo(base + height);
  image.col(kStep).setTo(base + 0.5 * height);
  image.col(192).setTo(base + 0.5 * height);
  return image;
}

double max_difference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

TEST(PhaseCongruency, IsNearOneAtAnIdealStepWhateverItsHeight) {
  const PhaseCongruency congruency(cv::Size(256, 128));
  for (const double height : {1.0, 20.0, 255.0}) {
    const cv::Mat result = congruency(step_image(height));
    for (const int row : {0, 63, 127}) EXPECT_GT(result.at<double>(row, kStep), 0.97) << height;
  }
}

TEST(PhaseCongruency, DoesNotPreferRowsOrColumns) {
  // Of odd size: an even one has a bin at the Nyquist frequency, which belongs to no direction.
  const cv::Mat image = levels(textured_image({75, 75}));
  const PhaseCongruency congruency(image.size());
  EXPECT_LT(max_difference(congruency(image.t()), congruency(image).t()), 1e-9);
}

TEST(PhaseCongruency, IsLowAwayFromAStepInSlightNoise) {
  const cv::Mat step = step_image(100.0);
  cv::Mat noise(step.size(), CV_64FC1);
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  const cv::Mat result = PhaseCongruency(step.size())(step + noise);
  EXPECT_GT(cv::mean(result.col(kStep))[0], 0.9);
  EXPECT_LT(cv::mean(result.colRange(104, 152))[0], 0.1);
}

TEST(PhaseCongruency, IsZeroOnFlatImages) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(31, 17), cv::Size(256, 128)}) {
    for (const double level : {0.0, 0.3, 127.0, 255.0}) {
      const cv::Mat result = PhaseCongruency(size)(cv::Mat(size, CV_64FC1, cv::Scalar(level)));
      EXPECT_LT(cv::norm(result, cv::NORM_INF), 1e-8) << size << " at " << level;
    }
  }
}

TEST(PhaseCongruency, StaysWithinItsRange) {
  for (const cv::Size size :
       {cv::Size(8, 8), cv::Size(9, 8), cv::Size(64, 33), cv::Size(101, 53)}) {
    const cv::Mat image = levels(noisy(textured_image(size), 25.0));
    const cv::Mat result = PhaseCongruency(size)(image);
    EXPECT_TRUE(cv::checkRange(result, true, nullptr, 0.0, 1.0)) << size;
  }
}

}  // namespace
}  // namespace raywalk
