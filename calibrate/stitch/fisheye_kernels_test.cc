#include "calibrate/stitch/fisheye_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

constexpr int kWidth = 40, kHeight = 30;

// A picture of random bytes with its border.
cv::Mat random_picture() {
  cv::Mat picture(kHeight + 2 * kFisheyeBorder, kWidth + 2 * kFisheyeBorder, CV_8UC4);
  cv::RNG(7).fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

FisheyePixels pixels_of(const cv::Mat& picture) {
  return {picture.ptr(kFisheyeBorder) + 4 * kFisheyeBorder,
          static_cast<std::int64_t>(picture.step[0])};
}

std::vector<FisheyeSample> random_samples(int count, float least_root, float most_root) {
  cv::RNG random(3);
  std::vector<FisheyeSample> samples;
  for (int i = 0; i < count; ++i) {
    samples.push_back({random.uniform(-0.5F, kWidth - 0.5F), random.uniform(-0.5F, kHeight - 0.5F),
                       random.uniform(least_root, most_root)});
  }
  return samples;
}

std::vector<std::int16_t> sampled(const FisheyeKernels& kernels, const cv::Mat& picture,
                                  const std::vector<FisheyeSample>& samples,
                                  const ColourRoots& colours) {
  std::vector<std::int16_t> levels(3 * samples.size());
  kernels.sample(pixels_of(picture), samples.data(), static_cast<int>(samples.size()), colours,
                 levels.data());
  return levels;
}

// Keys' cubic convolution with a = -1/2, from its definition as a function of distance (R. Keys,
// "Cubic convolution interpolation for digital image processing", 1981, equation 4).
double keys(double x) {
  x = std::abs(x);
  if (x < 1.0) return 1.5 * x * x * x - 2.5 * x * x + 1.0;
  if (x < 2.0) return -0.5 * x * x * x + 2.5 * x * x - 4.0 * x + 2.0;
  return 0.0;
}

double interpolated(const cv::Mat& picture, const FisheyeSample& sample, int channel) {
  double sum = 0.0;
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      sum += keys(sample.u - (u - kFisheyeBorder)) * keys(sample.v - (v - kFisheyeBorder)) *
             picture.at<cv::Vec4b>(v, u)[channel];
    }
  }
  return std::clamp(sum, 0.0, 255.0);
}

TEST(FisheyeKernelsTest, InterpolatesCubicallyAtSubpixelPositions) {
  const cv::Mat picture = random_picture();
  const auto samples = random_samples(500, 1.0F, 1.0F);
  const auto levels = sampled(portable_fisheye_kernels(), picture, samples, {});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      // Half a part is the rounding of the result.
      EXPECT_NEAR(levels[3 * i + c] / double{kLevelParts},
                  interpolated(picture, samples[i], static_cast<int>(c)), 0.51 / kLevelParts);
    }
  }
}

TEST(FisheyeKernelsTest, EveryProcessorGetsTheSamePanorama) {
  const cv::Mat picture = random_picture();
  const auto samples = random_samples(20000, 0.5F, 2.0F);
  const ColourRoots colours{{0.9F, 1.0F, 1.15F}};
  EXPECT_EQ(sampled(fisheye_kernels(), picture, samples, colours),
            sampled(portable_fisheye_kernels(), picture, samples, colours));
}

// Dark levels lie on sRGB's straight toe, for which the correction is an approximation.
TEST(FisheyeKernelsTest, CorrectsLightByTheTransferCurve) {
  for (const double factor : {0.7, 0.95, 1.1, 1.6}) {
    for (int level = 0; level <= 255; ++level) {
      const cv::Mat picture(kHeight + 2 * kFisheyeBorder, kWidth + 2 * kFisheyeBorder, CV_8UC4,
                            cv::Scalar::all(level));
      const float root = static_cast<float>(std::pow(factor, 1.0 / kSrgbExponent));
      const double truth =
          std::min(srgb_level_from_linear(factor * linear_from_srgb_level(level)), 255.0);
      const auto levels = sampled(fisheye_kernels(), picture, {{7.3F, 5.1F, root}}, {});
      EXPECT_NEAR(levels[0] / double{kLevelParts}, truth,
                  std::min<double>(level, truth) < 11 ? 0.8 : 0.05)
          << factor << " " << level;
    }
  }
}

}  // namespace
}  // namespace raywalk::calibrate
