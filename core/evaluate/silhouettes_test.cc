#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/test_images.h"

namespace raywalk {
namespace {

const cv::Size kSize(64, 32);
constexpr double kPixels = 64.0 * 32.0;

cv::Mat flat_distances(int mm) { return {kSize, CV_16UC1, cv::Scalar(mm)}; }

// Columns 16 to 47 at one distance, the others at another: silhouettes far from the seam.
cv::Mat two_distances(int inside_mm, int outside_mm) {
  cv::Mat distances = flat_distances(outside_mm);
  distances.colRange(16, 48).setTo(inside_mm);
  return distances;
}

int near_pixels(const cv::Mat& distances_mm) {
  return cv::countNonZero(near_silhouettes(distances_mm));
}

double db_of_error(double levels) { return 20.0 * std::log10(255.0 / levels); }

// Both pixels of the pair and two beyond each: 6 columns at either side.
constexpr int kTwoBands = 2 * 6 * 32;

TEST(NearSilhouettes, AreWhereDistancesHaveARatioAbove1Point15) {
  EXPECT_EQ(near_pixels(flat_distances(1000)), 0);
  EXPECT_EQ(near_pixels(two_distances(1000, 1150)), 0);
  EXPECT_EQ(near_pixels(two_distances(1150, 1000)), 0);
  EXPECT_EQ(near_pixels(two_distances(1000, 1151)), kTwoBands);
  EXPECT_EQ(near_pixels(two_distances(1151, 1000)), kTwoBands);
}

TEST(NearSilhouettes, NoSurfaceIsFarthest) {
  EXPECT_EQ(near_pixels(two_distances(0, 65535)), 0);
  EXPECT_EQ(near_pixels(two_distances(0, 56988)), 0) << "65535 / 1.15 = 56987";
  EXPECT_EQ(near_pixels(two_distances(0, 56986)), kTwoBands);
}

TEST(NearSilhouettes, AreTwoPixelsWideAndGoRoundTheSeam) {
  cv::Mat distances = flat_distances(1000);
  distances.colRange(0, 32).setTo(2000);
  const cv::Mat near = near_silhouettes(distances);
  ASSERT_EQ(near.size(), kSize);
  for (int column = 0; column < kSize.width; ++column) {
    const bool in_band = column <= 2 || (column >= 29 && column <= 34) || column >= 61;
    EXPECT_EQ(cv::countNonZero(near.col(column)), in_band ? kSize.height : 0) << column;
  }
}

TEST(NearSilhouettes, EndAtThePoles) {
  cv::Mat distances = flat_distances(1000);
  distances.rowRange(0, 8).setTo(2000);
  const cv::Mat near = near_silhouettes(distances);
  for (int row = 0; row < kSize.height; ++row) {
    EXPECT_EQ(cv::countNonZero(near.row(row)), row >= 5 && row <= 10 ? kSize.width : 0) << row;
  }
}

TEST(SilhouetteScores, TellErrorsNearSilhouettesFromOthers) {
  const cv::Mat truth = flat_image(kSize, {100, 100, 100});
  const cv::Mat distances = two_distances(1000, 2000);
  cv::Mat view = flat_image(kSize, {105, 105, 105});
  view.setTo(cv::Scalar::all(120), near_silhouettes(distances));
  const SilhouetteScores scores = score_silhouettes(view, truth, distances);
  EXPECT_NEAR(scores.near_psnr_db, db_of_error(20.0), 1e-9);
  EXPECT_NEAR(scores.elsewhere_psnr_db, db_of_error(5.0), 1e-9);
  EXPECT_DOUBLE_EQ(scores.near_share, kTwoBands / kPixels);
  EXPECT_EQ(scores.specks_per_mpx, 0.0);
  EXPECT_EQ(score_silhouettes(truth, truth, distances).near_psnr_db, kMaxPsnrDb);
}

TEST(SilhouetteScores, ATruthMayHaveNoSilhouetteOrNothingElse) {
  const cv::Mat truth = flat_image(kSize, {100, 100, 100});
  const SilhouetteScores none = score_silhouettes(truth, truth, flat_distances(1000));
  EXPECT_TRUE(std::isnan(none.near_psnr_db));
  EXPECT_EQ(none.elsewhere_psnr_db, kMaxPsnrDb);
  EXPECT_EQ(none.near_share, 0.0);
  cv::Mat stripes = flat_distances(1000);
  for (int column = 0; column < kSize.width; column += 2) stripes.col(column).setTo(2000);
  const SilhouetteScores all = score_silhouettes(truth, truth, stripes);
  EXPECT_EQ(all.near_psnr_db, kMaxPsnrDb);
  EXPECT_TRUE(std::isnan(all.elsewhere_psnr_db));
  EXPECT_EQ(all.near_share, 1.0);
}

TEST(SilhouetteScores, MaskedPixelsDoNotCount) {
  const cv::Mat truth = flat_image(kSize, {100, 100, 100});
  cv::Mat view = flat_image(kSize, {105, 105, 105});
  view.colRange(32, 64).setTo(cv::Scalar::all(200));
  view.at<cv::Vec3b>(8, 8) = {200, 105, 105};
  view.at<cv::Vec3b>(8, 56) = {0, 200, 200};
  cv::Mat mask = cv::Mat::zeros(kSize, CV_8UC1);
  mask.colRange(0, 32).setTo(1);
  cv::Mat distances = two_distances(1000, 2000);
  const SilhouetteScores scores = score_silhouettes(view, truth, distances, mask);
  EXPECT_NEAR(scores.near_psnr_db, db_of_error(5.0), 1e-9);
  EXPECT_DOUBLE_EQ(scores.near_share, 6.0 / 32.0);
  EXPECT_DOUBLE_EQ(scores.specks_per_mpx, 1e6 / (kPixels / 2.0)) << "the one that counts";
}

// Specks among `surroundings` where one pixel of the view, and of the truth, is at other levels.
double specks_of(const cv::Scalar& surroundings, const cv::Vec3b& in_view,
                 const cv::Vec3b& in_truth = {100, 100, 100}) {
  cv::Mat view = flat_image(kSize, surroundings), truth = flat_image(kSize, {100, 100, 100});
  view.at<cv::Vec3b>(16, 40) = in_view;
  truth.at<cv::Vec3b>(16, 40) = in_truth;
  return score_silhouettes(view, truth, flat_distances(1000)).specks_per_mpx * kPixels / 1e6;
}

// Wrong by over 48 levels in some channel, over 32 off what is around, where the truth is smooth.
TEST(Specks, DifferFromTheTruthAndFromWhatIsAround) {
  const cv::Scalar right(100, 100, 100), wrong(160, 160, 160);
  EXPECT_DOUBLE_EQ(specks_of(right, {100, 149, 100}), 1.0);
  EXPECT_DOUBLE_EQ(specks_of(right, {100, 148, 100}), 0.0);
  EXPECT_DOUBLE_EQ(specks_of(right, {100, 100, 51}), 1.0);
  EXPECT_DOUBLE_EQ(specks_of(right, {52, 100, 100}), 0.0);
  EXPECT_DOUBLE_EQ(specks_of(wrong, {160, 160, 160}), 0.0);
  EXPECT_DOUBLE_EQ(specks_of(wrong, {192, 192, 192}), 0.0);
  EXPECT_DOUBLE_EQ(specks_of(wrong, {160, 193, 160}), 1.0);
  EXPECT_DOUBLE_EQ(specks_of(right, {200, 200, 200}, {100, 115, 100}), 1.0);
  EXPECT_DOUBLE_EQ(specks_of(right, {200, 200, 200}, {100, 116, 100}), 0.0);
}

// Three of the nine pixels around a column are of it, six around a double one, also at the seam.
TEST(Specks, AreIsolated) {
  const cv::Mat truth = flat_image(kSize, {100, 100, 100});
  for (const int column : {0, 20, 63}) {
    cv::Mat view = truth.clone();
    view.col(column).setTo(cv::Scalar::all(200));
    const auto specks = [&] {
      return score_silhouettes(view, truth, flat_distances(1000)).specks_per_mpx;
    };
    EXPECT_DOUBLE_EQ(specks(), 1e6 * kSize.height / kPixels) << column;
    view.col((column + 1) % kSize.width).setTo(cv::Scalar::all(200));
    EXPECT_EQ(specks(), 0.0) << column;
  }
}

TEST(SilhouetteScores, RefuseWhatDoesNotFit) {
  const cv::Mat image = flat_image(kSize, {});
  EXPECT_THROW(score_silhouettes(image, image, cv::Mat::ones(16, 32, CV_16UC1)), Error);
  EXPECT_THROW(score_silhouettes(image, image, cv::Mat::ones(kSize, CV_32FC1)), Error);
  EXPECT_THROW(score_silhouettes(image, flat_image({32, 16}, {}), flat_distances(1)), Error);
  EXPECT_THROW(score_silhouettes(image, image, flat_distances(1), cv::Mat::zeros(kSize, CV_8UC1)),
               Error);
}

}  // namespace
}  // namespace raywalk
