#include "build_lf/refine/refine_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "build_lf/refine/sharpening.h"
#include "core/base/error.h"
#include "core/view/test_room.h"

namespace raywalk::build_lf {
namespace {

TEST(RefinePlanTest, ALineHasAtLeastTwo) {
  const TestRoom room({.spacing_m = 0.125, .width = 16, .distance_every = 100});
  for (const auto& line : stations_to_develop(room.room(), 0)) EXPECT_GE(line.size(), 2u);
}

TEST(RefinePlanTest, ANumberIsMetByEvenSpacing) {
  const TestRoom made({.spacing_m = 0.03125, .width = 16, .distance_every = 4});
  const Room& room = made.room();
  for (const int asked : {8, 12, 20, 36, 60}) {
    int count = 0;
    for (const auto& line : stations_to_develop(room, asked))
      count += static_cast<int>(line.size());
    EXPECT_LE(count, asked);
    EXPECT_GT(count, asked / 2) << "the spacing is a multiple of the captured one";
  }
  EXPECT_THROW(stations_to_develop(room, -1), UsageError);
  EXPECT_THROW(stations_to_develop(room, 1000), UsageError);
}

TEST(DevelopedWidthTest, IsTwiceTheCapturedOneUnlessThatIsHuge) {
  EXPECT_EQ(developed_width({1024, 512}, 0), 2048);
  EXPECT_EQ(developed_width({1022, 511}, 0), 2044);
  EXPECT_EQ(developed_width({5760, 2880}, 0), kUsualWidth);
  EXPECT_EQ(developed_width({11520, 5760}, 0), 11520);
  EXPECT_EQ(developed_width({1024, 512}, 1024), 1024);
  for (const int asked : {1020, 2052, 1026, -4}) {
    EXPECT_THROW(developed_width({1024, 512}, asked), UsageError) << asked;
  }
}

TEST(SourcesTest, AreTheNearestAndSomeOfAllThatSeeTheSurfacesAsWell) {
  const Grid grid = synthetic_grid({.side_m = 4.0, .spacing_m = 0.0625});
  const StationIndex station{0, 30};
  const auto away_m = [&](StationIndex of) {
    return (grid.station(of).position_m - grid.station(station).position_m).norm();
  };
  const auto sources = sources_of(grid, station, 2.0);
  ASSERT_EQ(sources.size(), static_cast<std::size_t>(kMostSources));
  EXPECT_EQ(std::set(sources.begin(), sources.end()).size(), sources.size());
  double farthest_m = 0.0;
  for (const StationIndex& source : sources) {
    EXPECT_FALSE(source == station);
    EXPECT_LE(away_m(source), 2.0);
    farthest_m = std::max(farthest_m, away_m(source));
  }
  EXPECT_GT(farthest_m, 1.7);
  // The nearest 20 of a line are within 10 spacings.
  EXPECT_GE(std::ranges::count_if(
                sources, [&](StationIndex source) { return away_m(source) < 10.5 * 0.0625; }),
            20);
  // Surfaces nearer than the next station: the nearest stations all the same.
  EXPECT_EQ(sources_of(grid, station, 0.0).size(), static_cast<std::size_t>(kMostSources / 2));
}

TEST(SourcesTest, AFewStationsAreAllSources) {
  const Grid grid = synthetic_grid({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.25});
  const double everywhere_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(sources_of(grid, {0, 2}, everywhere_m).size(), grid.lines[0].stations.size() - 1);
}

TEST(MedianDistanceTest, IsOfWhatIsKnown) {
  const std::vector<float> inverse{-1.0f, 0.5f, 0.25f, 0.125f, -1.0f};
  EXPECT_DOUBLE_EQ(median_distance_m(inverse), 4.0);
  EXPECT_EQ(median_distance_m({}), std::numeric_limits<double>::infinity());
  const std::vector<float> sky(5, 0.0f);
  EXPECT_EQ(median_distance_m(sky), std::numeric_limits<double>::infinity());
}

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
double off_photograph(const cv::Mat& shown, const cv::Mat& photograph) {
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
      EXPECT_LT(off_photograph(sharp, photograph),
                0.75 * off_photograph(sharpened(picture, kCaptured.width, 0.0), photograph))
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
