#include "core/evaluate/metrics.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
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
#include "core/evaluate/test_images.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Writes the image as one raw frame and returns the ffmpeg arguments that read it.
std::string raw_input(const cv::Mat& image, const std::filesystem::path& file) {
  const cv::Mat frame = image.isContinuous() ? image : image.clone();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(frame.data),
             static_cast<std::streamsize>(frame.total() * frame.elemSize()));
  return fmt::format(" -f rawvideo -pix_fmt {} -s {}x{} -i '{}'",
                     frame.channels() == 1 ? "gray" : "bgr24", frame.cols, frame.rows,
                     file.string());
}

// What `ffmpeg -lavfi FILTER` (psnr or ssim) on two gray or bgr24 images prints behind "KEY:"; NaN
// where it fails or is missing. `options` go before the inputs.
double ffmpeg_filter_value(const std::string& filter, const std::string& key, const cv::Mat& a,
                           const cv::Mat& b, const std::string& options = "") {
  const TestDirectory directory;
  const std::filesystem::path log = directory / "log";
  const std::string command = "ffmpeg -hide_banner -nostdin " + options +
                              raw_input(a, directory / "a.raw") +
                              raw_input(b, directory / "b.raw") + " -lavfi " + filter +
                              " -f null - >'" + log.string() + "' 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream in(log);
  const std::string output{std::istreambuf_iterator<char>(in), {}};
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

// A black image and the same with one row at `level`.
cv::Mat with_bright_row(cv::Size size, int row, double level) {
  cv::Mat image = flat_image(size, {0, 0, 0});
  image.row(row).setTo(cv::Scalar::all(level));
  return image;
}

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

// ffmpeg prints 6 decimals and averages over the planes in double like this function: the
// difference is at most half a unit of the last decimal.
TEST(Psnr, AgreesWithFfmpegOverRgb) {
  constexpr double kTolerance_db = 1e-6;
  const cv::Mat image = textured_image({512, 256});
  const cv::Mat odd = textured_image({131, 77});
  const std::vector<std::pair<cv::Mat, cv::Mat>> pairs = {
      {image, noisy(image, 1.0)},
      {image, noisy(image, 40.0)},
      {image, blurred(image, 2.0)},
      {image, adjusted(image, 0.8, 20.0)},
      {image, rolled(image, 7)},
      {image, image + cv::Scalar(9, 0, 0)},
      {image, image + cv::Scalar(0, 0, 9)},
      {odd, noisy(odd, 5.0)},
      {image, flat_image(image.size(), {90, 120, 150})}};
  for (const auto& [a, b] : pairs) {
    EXPECT_NEAR(psnr_db(a, b), ffmpeg_filter_value("psnr", "average", a, b), kTolerance_db);
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
      EXPECT_NEAR(ws_psnr_db(black, with_bright_row(size, row, kError)),
                  10.0 * std::log10(255.0 * 255.0 / weighted), 1e-9)
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

TEST(Ssim, AgreesWithFfmpeg) {
  const cv::Mat image = textured_image({512, 256});
  const cv::Mat dark = adjusted(image, 0.05, 0.0);
  const std::vector<std::pair<cv::Mat, cv::Mat>> pairs = {
      {image, noisy(image, 1.0)},
      {image, noisy(image, 40.0)},
      {image, blurred(image, 2.0)},
      {image, adjusted(image, 0.8, 20.0)},
      {image, adjusted(image, -1.0, 255.0)},
      {image, rolled(image, 7)},
      {dark, noisy(dark, 2.0)},
      {image, flat_image(image.size(), {90, 120, 150})}};
  for (const auto& [a, b] : pairs) EXPECT_NEAR(ssim(a, b), ffmpeg_ssim(a, b), kTolerance);
}

TEST(Ssim, AgreesWithFfmpegAtEverySize) {
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
