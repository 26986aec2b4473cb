#include "build_lf/refine/sharpening.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <utility>

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kCaptured{256, 128};

// A picture of the developed size, levels, with detail down to a pixel, periodic in theta.
cv::Mat scene(unsigned seed) {
  cv::Mat noise(2 * kCaptured.width, 2 * kCaptured.height, CV_32FC3);
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::NORMAL, 128.0, 60.0);
  cv::Mat around;
  cv::copyMakeBorder(noise, around, 16, 16, 0, 0, cv::BORDER_WRAP);
  cv::GaussianBlur(around, around, {}, 1.2);
  return around.rowRange(16, 16 + noise.rows).clone();
}

// What a camera of half the width captures of it.
cv::Mat photograph_of(const cv::Mat& picture) {
  cv::Mat captured, levels;
  cv::resize(picture, captured, {kCaptured.height, kCaptured.width}, 0.0, 0.0, cv::INTER_AREA);
  captured.convertTo(levels, CV_8U);
  return levels;
}

cv::Mat developed(const cv::Mat& picture) {
  cv::Mat levels;
  picture.convertTo(levels, CV_16U, kLevel);
  return levels;
}

cv::Mat blurred(const cv::Mat& picture, double sigma_px) {
  cv::Mat around;
  cv::copyMakeBorder(picture, around, 16, 16, 0, 0, cv::BORDER_WRAP);
  cv::GaussianBlur(around, around, {}, sigma_px);
  return around.rowRange(16, 16 + picture.rows).clone();
}

const cv::Mat1b kAll(kCaptured.width, kCaptured.height, 255);

// Of what views of the captured width show: bilinear samples, at 4 x 4 places around each pixel.
double error_of(const cv::Mat& shown, const cv::Mat& photograph) {
  cv::Mat views = cv::Mat::zeros(shown.size(), CV_32FC3);
  for (const double across : {-0.375, -0.125, 0.125, 0.375}) {
    for (const double down : {-0.375, -0.125, 0.125, 0.375}) {
      const cv::Mat shift = (cv::Mat1d(2, 3) << 1.0, 0.0, down, 0.0, 1.0, across);
      cv::Mat sampled, back;
      cv::warpAffine(shown, sampled, shift, shown.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
      sampled.convertTo(back, CV_32F);
      views += back / 16.0;
    }
  }
  const cv::Rect inside(4, 4, kCaptured.height - 8, kCaptured.width - 8);
  return cv::norm(photograph_of(views)(inside), photograph(inside), cv::NORM_L2);
}

TEST(SharpeningTest, UndoesTheBlurThatIsThere) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const cv::Mat truth = scene(seed), photograph = photograph_of(truth);
    double before = 0.0;
    for (const double sigma_px : {0.6, 0.9, 1.2}) {
      const cv::Mat picture = developed(blurred(truth, sigma_px));
      const double amount = measured_sharpening(picture, photograph, kAll);
      EXPECT_GT(amount, before) << sigma_px;
      before = amount;
      const cv::Mat sharp = sharpened(picture, kCaptured.width, amount);
      EXPECT_LT(error_of(sharp, photograph),
                0.75 * error_of(sharpened(picture, kCaptured.width, 0.0), photograph))
          << sigma_px;
    }
  }
}

TEST(SharpeningTest, NoiseOfThePhotographDoesNotAskForMore) {
  const cv::Mat truth = scene(4), picture = developed(blurred(truth, 0.9));
  cv::Mat noisy = photograph_of(truth), noise(noisy.size(), CV_16SC3);
  const double clean = measured_sharpening(picture, noisy, kAll);
  cv::RNG random(7);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 5.0);
  cv::add(noisy, noise, noisy, cv::noArray(), CV_8U);
  EXPECT_NEAR(measured_sharpening(picture, noisy, kAll), clean, 0.1);
}

TEST(SharpeningTest, NoiseOfThePictureAsksForLess) {
  const cv::Mat truth = scene(5), photograph = photograph_of(truth);
  cv::Mat picture = blurred(truth, 0.9), noise(picture.size(), CV_32FC3);
  const double clean = measured_sharpening(developed(picture), photograph, kAll);
  cv::RNG random(7);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 30.0);
  EXPECT_LT(measured_sharpening(developed(picture + noise), photograph, kAll), 0.7 * clean);
}

TEST(SharpeningTest, WhatCannotBeComparedDoesNotCount) {
  const cv::Mat truth = scene(6), picture = developed(blurred(truth, 0.9));
  cv::Mat photograph = photograph_of(truth);
  const double whole = measured_sharpening(picture, photograph, kAll);
  cv::Mat1b half = kAll.clone();
  half.rowRange(0, kCaptured.width / 2) = 0;
  // Detail of the wrong sign, where it is not compared.
  photograph.rowRange(0, kCaptured.width / 2) = cv::Scalar::all(128);
  EXPECT_NEAR(measured_sharpening(picture, photograph, half), whole, 0.1);
  EXPECT_EQ(measured_sharpening(picture, photograph, cv::Mat1b::zeros(half.size())), 1.0);
  const cv::Mat unknown = cv::Mat::zeros(picture.size(), picture.type());
  EXPECT_EQ(measured_sharpening(unknown, photograph, kAll), 1.0);
}

TEST(SharpeningTest, KeepsPlainPicturesAndGoesRoundTheSeam) {
  for (const auto& [captured, width] : {std::pair{32, 64}, {300, 400}, {1028, 1540}}) {
    const cv::Mat plain(width, 32, CV_16UC3, cv::Scalar::all(200 * kLevel));
    const cv::Mat expected(width, 32, CV_8UC3, cv::Scalar::all(200));
    EXPECT_EQ(cv::norm(sharpened(plain, captured, 1.5), expected, cv::NORM_INF), 0.0) << width;
  }
  // The same picture, turned: the seam is anywhere.
  const cv::Mat picture = developed(scene(8));
  cv::Mat turned;
  cv::vconcat(picture.rowRange(100, picture.rows), picture.rowRange(0, 100), turned);
  const cv::Mat sharp = sharpened(picture, kCaptured.width, 1.0);
  cv::Mat expected;
  cv::vconcat(sharp.rowRange(100, sharp.rows), sharp.rowRange(0, 100), expected);
  EXPECT_EQ(cv::norm(sharpened(turned, kCaptured.width, 1.0), expected, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace raywalk::build_lf
