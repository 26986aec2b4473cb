#include "core/files/jpeg_scan_check.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/files/jpeg_errors.h"

namespace raywalk {
namespace {

using Bytes = std::vector<unsigned char>;

// What the check says, "unreadable" if libjpeg does not read the header.
std::string damage_of(const Bytes& bytes) {
  jpeg_decompress_struct info{};
  JpegErrorTrap trap{};
  info.err = prepare(&trap);
  trap.manager.emit_message = [](j_common_ptr, int) {};
  std::string damage = "unreadable";
  if (setjmp(trap.start) == 0) {
    jpeg_create_decompress(&info);
    jpeg_mem_src(&info, bytes.data(), bytes.size());
    jpeg_read_header(&info, TRUE);
    damage = scan_damage(info);
  }
  jpeg_destroy_decompress(&info);
  return damage;
}

Bytes jpeg_of(const cv::Mat& picture, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  cv::imencode(".jpg", picture, bytes, parameters);
  return bytes;
}

// Edges, plain surfaces and noise.
cv::Mat scene(cv::Size size, int type) {
  cv::Mat picture(size, type, cv::Scalar(90, 140, 200));
  cv::RNG random(7);
  for (int i = 0; i < 60; ++i) {
    const cv::Point at(random.uniform(0, size.width), random.uniform(0, size.height));
    const cv::Size side(random.uniform(2, 40), random.uniform(2, 40));
    cv::rectangle(
        picture, cv::Rect(at, side),
        cv::Scalar(random.uniform(0, 256), random.uniform(0, 256), random.uniform(0, 256)),
        cv::FILLED);
  }
  cv::Mat noise(size, type);
  random.fill(noise, cv::RNG::NORMAL, 0, 3);
  return picture + noise;
}

TEST(ScanDamage, WholeFilesHaveNone) {
  cv::Mat checkered(40, 56, CV_8UC3, cv::Scalar::all(0));
  for (int v = 0; v < checkered.rows; ++v) {
    for (int u = v % 2; u < checkered.cols; u += 2) checkered.at<cv::Vec3b>(v, u) = {255, 255, 255};
  }
  const std::vector<cv::Mat> pictures = {scene({150, 77}, CV_8UC3), scene({149, 80}, CV_8UC1),
                                         checkered, cv::Mat(9, 1, CV_8UC3, cv::Scalar::all(255)),
                                         cv::Mat(1, 9, CV_8UC3, cv::Scalar::all(0))};
  for (const cv::Mat& picture : pictures) {
    for (const int quality : {1, 10, 50, 90, 100}) {
      for (const int restart : {0, 1, 3, 100}) {
        for (const int optimised : {0, 1}) {
          const Bytes bytes = jpeg_of(picture, {cv::IMWRITE_JPEG_QUALITY, quality,  //
                                                cv::IMWRITE_JPEG_RST_INTERVAL, restart,
                                                cv::IMWRITE_JPEG_OPTIMIZE, optimised});
          EXPECT_EQ(damage_of(bytes), "") << picture.size() << quality << restart << optimised;
        }
      }
    }
  }
}

TEST(ScanDamage, KindsThatAreNotExaminedHaveNone) {
  Bytes bytes = jpeg_of(scene({64, 32}, CV_8UC3), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  bytes[bytes.size() / 2] ^= 0x55;
  EXPECT_EQ(damage_of(bytes), "");
}

// As libjpeg's warnings alone find less than half of them.
TEST(ScanDamage, MostFlipsThatSpoilAPictureAreFound) {
  const Bytes whole = jpeg_of(scene({256, 128}, CV_8UC3));
  const cv::Mat picture = cv::imdecode(whole, cv::IMREAD_COLOR);
  int spoilt = 0, found = 0;
  for (std::size_t at = whole.size() / 8; at + 4 < whole.size(); at += 37) {
    Bytes bytes = whole;
    bytes[at] ^= 0x41;
    bytes[at + 1] ^= 0x82;
    testing::internal::CaptureStderr();
    const cv::Mat other = cv::imdecode(bytes, cv::IMREAD_COLOR);
    const bool warned = !testing::internal::GetCapturedStderr().empty();
    if (!other.empty() && cv::norm(other, picture, cv::NORM_L1) < 3.0 * picture.total() * 3) {
      continue;
    }
    ++spoilt;
    found += warned || !damage_of(bytes).empty() ? 1 : 0;
  }
  EXPECT_GT(spoilt, 50);
  EXPECT_GT(found, 0.75 * spoilt) << "of " << spoilt;
}

// Damaged tables, sizes and sampling too.
TEST(ScanDamage, AnyDamageEndsInAnAnswer) {
  const Bytes whole = jpeg_of(scene({64, 48}, CV_8UC3), {cv::IMWRITE_JPEG_RST_INTERVAL, 2});
  constexpr std::size_t kHeader = 640;  // every byte of it, and some of the data
  for (std::size_t at = 2; at < whole.size(); at += at < kHeader ? 1 : 23) {
    for (const unsigned char mask : {0x01, 0x80, 0xFF}) {
      Bytes bytes = whole;
      bytes[at] ^= mask;
      damage_of(bytes);
    }
    damage_of(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at)));
  }
}

}  // namespace
}  // namespace raywalk
