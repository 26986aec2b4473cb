#include "core/evaluate/metrics.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/evaluate/fsim.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

cv::Mat flat_image(cv::Size size, const cv::Scalar& bgr) { return {size, CV_8UC3, bgr}; }

// Smooth coloured waves, boxes and lines: gradients, edges and texture in one.
cv::Mat textured_image(cv::Size size) {
  cv::Mat image(size, CV_8UC3);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const double waves =
          std::sin(0.13 * col) * std::cos(0.09 * row) + std::sin(0.011 * col * row);
      image.at<cv::Vec3b>(row, col) = {
          cv::saturate_cast<std::uint8_t>(120 + 45 * waves),
          cv::saturate_cast<std::uint8_t>(110 + 60.0 * row / size.height),
          cv::saturate_cast<std::uint8_t>(90 - 30 * waves)};
    }
  }
  const cv::Rect box(size.width / 5, size.height / 4, size.width / 4, size.height / 3);
  cv::rectangle(image, box, cv::Scalar(30, 200, 240), cv::FILLED);
  cv::line(image, {0, size.height - 1}, {size.width - 1, size.height / 2}, cv::Scalar(250, 20, 10));
  return image;
}

// With Gaussian noise of the given standard deviation in 8-bit levels.
cv::Mat noisy(const cv::Mat& image, double deviation, int seed = 1) {
  cv::Mat noise(image.size(), CV_64FC3);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, deviation);
  cv::Mat sum;
  cv::add(image, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

cv::Mat blurred(const cv::Mat& image, double sigma_px) {
  cv::Mat out;
  cv::GaussianBlur(image, out, cv::Size(), sigma_px);
  return out;
}

// Multiplied by gain, offset added, rounded and cut off at 0 and 255.
cv::Mat adjusted(const cv::Mat& image, double gain, double offset) {
  cv::Mat out;
  image.convertTo(out, CV_8U, gain, offset);
  return out;
}

// Rotated about the vertical: columns move to the right and wrap around.
cv::Mat rolled(const cv::Mat& image, int columns) {
  const int kept = image.cols - columns;
  cv::Mat out;
  cv::hconcat(image.colRange(kept, image.cols), image.colRange(0, kept), out);
  return out;
}

// What `ffmpeg -lavfi FILTER` (psnr or ssim) on two images prints behind "KEY:"; NaN where it fails
// or is missing. `options` go before the inputs.
double ffmpeg_filter_value(const std::string& filter, const std::string& key, const cv::Mat& a,
                           const cv::Mat& b, const std::string& options = "") {
  const TestDirectory directory;
  write_image(directory / "a.png", a);
  write_image(directory / "b.png", b);
  const std::string command = fmt::format(
      "cd {} && ffmpeg -hide_banner -nostdin {} -i a.png -i b.png -lavfi {} -f null - "
      ">log 2>&1",
      directory.path().string(), options, filter);
  const int status = std::system(command.c_str());
  const std::string output = read_file(directory / "log");
  std::smatch match;
  const std::regex value(" " + key + ":(-?[0-9.]+|inf)");
  if (status == 0 && std::regex_search(output, match, value)) return std::stod(match[1]);
  ADD_FAILURE() << command << ": " << output;
  return std::nan("");
}

TEST(ImagePair, IsOfColourImagesOfOneSizeLargeEnough) {
  const cv::Mat colour = flat_image({16, 8}, {});
  EXPECT_THAT(
      [&] {
        require_image_pair(colour, flat_image({16, 9}, {}), 1);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("16x8"), HasSubstr("16x9"))));
  for (const int type : {CV_8UC1, CV_8UC4, CV_16UC3, CV_32FC3}) {
    const cv::Mat other = cv::Mat::zeros(8, 16, type);
    EXPECT_THAT([&] { require_image_pair(colour, other, 1); },
                ThrowsMessage<Error>(HasSubstr(cv::typeToString(type))));
    EXPECT_THROW(require_image_pair(other, colour, 1), Error);
  }
  const cv::Mat stack({8, 8, 8}, CV_8UC3);
  EXPECT_THROW(require_image_pair(colour, cv::Mat(), 1), Error);
  EXPECT_THROW(require_image_pair(stack, stack, 1), Error);
  for (const cv::Size size : {cv::Size(7, 8), cv::Size(8, 7)}) {
    const cv::Mat image = textured_image(size);
    EXPECT_THAT([&] { ssim(image, image); }, ThrowsMessage<Error>(HasSubstr("at least 8x8")));
    EXPECT_THAT([&] { fsim(image, image); }, ThrowsMessage<Error>(HasSubstr("at least 8x8")));
  }
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(MeanSquaredError, AveragesChannelsOfThePixelsThatCount) {
  const cv::Mat a = flat_image({4, 2}, {10, 10, 10});
  cv::Mat b = a.clone();
  b.at<cv::Vec3b>(1, 3) = {13, 10, 6};  // 9 + 16 over 8 pixels of 3 channels
  EXPECT_DOUBLE_EQ(mean_squared_error(a, b), 25.0 / 24.0);
  EXPECT_DOUBLE_EQ(mean_squared_error(b, a), 25.0 / 24.0);
  b.at<cv::Vec3b>(0, 0) = {200, 200, 200};
  cv::Mat mask = cv::Mat::zeros(a.size(), CV_8UC1);
  mask.at<std::uint8_t>(1, 3) = 1;
  mask.at<std::uint8_t>(1, 2) = 255;
  EXPECT_DOUBLE_EQ(mean_squared_error(a, b, mask), 25.0 / 6.0);
}

TEST(Psnr, LeavesOutWhatIsMasked) {
  const cv::Mat a = flat_image({64, 32}, {50, 60, 70});
  cv::Mat b = flat_image({64, 32}, {55, 65, 75});
  b.rowRange(20, 32).setTo(cv::Scalar(200, 0, 200));
  cv::Mat mask = cv::Mat::zeros(a.size(), CV_8UC1);
  mask.rowRange(0, 20).setTo(255);
  const double expected_db = 20.0 * std::log10(255.0 / 5.0);
  EXPECT_LT(psnr_db(a, b), expected_db - 10.0);
  EXPECT_NEAR(psnr_db(a, b, mask), expected_db, 1e-12);
  EXPECT_NEAR(ws_psnr_db(a, b, mask), expected_db, 1e-12);
  EXPECT_NEAR(ws_psnr_db(a, b, cv::Mat(a.size(), CV_8UC1, cv::Scalar(1))), ws_psnr_db(a, b), 1e-12);
  EXPECT_THAT([&] { ws_psnr_db(a, b, cv::Mat::zeros(a.size(), CV_8UC1)); },
              ThrowsMessage<Error>(HasSubstr("selects no pixel")));
  EXPECT_THROW(mean_squared_error(a, b, cv::Mat::ones(64, 32, CV_8UC1)), Error);
  EXPECT_THROW(mean_squared_error(a, b, cv::Mat::ones(a.size(), CV_32FC1)), Error);
}

TEST(Psnr, HasItsLimits) {
  const cv::Mat image = textured_image({64, 32});
  EXPECT_EQ(psnr_db(image, image), kInfinity);
  EXPECT_EQ(ws_psnr_db(image, image), kInfinity);
  const cv::Mat black = flat_image({64, 32}, {0, 0, 0});
  const cv::Mat white = flat_image({64, 32}, {255, 255, 255});
  EXPECT_NEAR(psnr_db(black, white), 0.0, 1e-12);
  EXPECT_NEAR(ws_psnr_db(black, white), 0.0, 1e-12);
}

// An image and what has become of it.
std::vector<std::pair<cv::Mat, cv::Mat>> disturbed_images() {
  const cv::Mat image = textured_image({512, 256}), dark = adjusted(image, 0.05, 0.0);
  return {{image, noisy(image, 1.0)},
          {image, noisy(image, 40.0)},
          {image, blurred(image, 2.0)},
          {image, adjusted(image, 0.8, 20.0)},
          {image, adjusted(image, -1.0, 255.0)},
          {image, rolled(image, 7)},
          {image, image + cv::Scalar(9, 0, 0)},
          {image, image + cv::Scalar(0, 0, 9)},
          {dark, noisy(dark, 2.0)},
          {image, flat_image(image.size(), {90, 120, 150})}};
}

// ffmpeg prints 6 decimals and averages over the planes in double like this function: the
// difference is at most half a unit of the last decimal.
TEST(Psnr, AgreesWithFfmpegOverRgb) {
  std::vector<std::pair<cv::Mat, cv::Mat>> pairs = disturbed_images();
  const cv::Mat odd = textured_image({131, 77});
  pairs.emplace_back(odd, noisy(odd, 5.0));
  for (const auto& [a, b] : pairs) {
    EXPECT_NEAR(psnr_db(a, b), ffmpeg_filter_value("psnr", "average", a, b), 1e-6);
  }
}

// Row v of H lies at phi = 90 - (v + 0.5) / H 180 degrees, and the weights add up in closed form:
// sum cos(phi) = 1 / sin(pi / (2 H)) (a sum of cosines in arithmetic progression). So an error e in
// row v alone gives WMSE = e^2 cos(phi) sin(pi / (2 H)).
TEST(WsPsnr, IsTheClosedFormForAnErrorInOneRow) {
  constexpr double kError = 40.0;
  for (const int height : {1, 2, 9, 32, 257}) {
    const cv::Size size(2 * height, height);
    const cv::Mat black = flat_image(size, {0, 0, 0});
    for (const int row : {0, height / 3, height - 1}) {
      const double phi = std::numbers::pi * (0.5 - (row + 0.5) / height);
      const double weighted =
          kError * kError * std::cos(phi) * std::sin(std::numbers::pi / (2.0 * height));
      cv::Mat bright = black.clone();
      bright.row(row).setTo(cv::Scalar::all(kError));
      EXPECT_NEAR(ws_psnr_db(black, bright), 10.0 * std::log10(255.0 * 255.0 / weighted), 1e-9)
          << "row " << row << " of " << height;
    }
  }
}

// metrics.h says why.
constexpr double kTolerance = 1e-6;
constexpr const char* kWithoutSimd = "-cpuflags 0";

cv::Mat grey(const cv::Mat& bgr) {
  cv::Mat luma;
  cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
  return luma;
}

double ffmpeg_ssim(const cv::Mat& a, const cv::Mat& b, const std::string& options = "") {
  return ffmpeg_filter_value("ssim", "Y", grey(a), grey(b), options);
}

TEST(Ssim, AgreesWithFfmpegAtEverySize) {
  for (const auto& [a, b] : disturbed_images()) {
    EXPECT_NEAR(ssim(a, b), ffmpeg_ssim(a, b), kTolerance);
  }
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(9, 31), cv::Size(24, 16), cv::Size(50, 11),
                              cv::Size(131, 77), cv::Size(200, 100)}) {
    const cv::Mat a = textured_image(size);
    const cv::Mat b = noisy(a, 20.0);
    EXPECT_NEAR(ssim(a, b), ffmpeg_ssim(a, b, kWithoutSimd), kTolerance) << size;
  }
}

TEST(Ssim, IsOneForEqualLumaAndSymmetric) {
  const cv::Mat a = textured_image({128, 64});
  const cv::Mat b = noisy(a, 12.0);
  EXPECT_DOUBLE_EQ(ssim(a, a), 1.0);
  EXPECT_DOUBLE_EQ(ssim(a, b), ssim(b, a));
}

TEST(Fsim, IsOneForEqualImages) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(131, 77), cv::Size(1024, 512)}) {
    const cv::Mat image = textured_image(size);
    EXPECT_NEAR(fsim(image, image), 1.0, 1e-12) << size;
  }
}

TEST(Fsim, IsThatOfTheLuma) {
  const cv::Mat a = textured_image({256, 128}), b = noisy(a, 10.0);
  const auto greyed = [](const cv::Mat& bgr) {
    cv::Mat image;
    cv::cvtColor(grey(bgr), image, cv::COLOR_GRAY2BGR);
    return image;
  };
  EXPECT_NEAR(fsim(a, b), fsim(greyed(a), greyed(b)), 1e-3);
  EXPECT_GT(std::abs(fsim(a, b) - fsim(a, greyed(a))), 1e-3);
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
  const auto doubled = [](const cv::Mat& image) {
    cv::Mat out;
    cv::resize(image, out, {}, 2.0, 2.0, cv::INTER_NEAREST);
    return out;
  };
  EXPECT_NEAR(fsim(doubled(small), doubled(small_blurred)), fsim(small, small_blurred), 1e-9);
}

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
  // No surface counts as the farthest.
  EXPECT_EQ(near_pixels(two_distances(0, 65535)), 0);
  EXPECT_EQ(near_pixels(two_distances(0, 56988)), 0) << "65535 / 1.15 = 56987";
  EXPECT_EQ(near_pixels(two_distances(0, 56986)), kTwoBands);
}

TEST(NearSilhouettes, AreTwoPixelsWideGoRoundTheSeamAndEndAtThePoles) {
  cv::Mat distances = flat_distances(1000);
  distances.colRange(0, 32).setTo(2000);
  const cv::Mat near = near_silhouettes(distances);
  ASSERT_EQ(near.size(), kSize);
  for (int column = 0; column < kSize.width; ++column) {
    const bool in_band = column <= 2 || (column >= 29 && column <= 34) || column >= 61;
    EXPECT_EQ(cv::countNonZero(near.col(column)), in_band ? kSize.height : 0) << column;
  }
  distances = flat_distances(1000);
  distances.rowRange(0, 8).setTo(2000);
  const cv::Mat above = near_silhouettes(distances);
  for (int row = 0; row < kSize.height; ++row) {
    EXPECT_EQ(cv::countNonZero(above.row(row)), row >= 5 && row <= 10 ? kSize.width : 0) << row;
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
