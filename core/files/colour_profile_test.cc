#include "core/files/colour_profile.h"

#include <gtest/gtest.h>
#include <lcms2.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/jpeg.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

std::string bytes_of_profile(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  return bytes;
}

// Adobe RGB (1998), 4.3.1: white, primaries and gamma.
std::string adobe_rgb() {
  const cmsCIExyY white{0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
  cmsToneCurve* gamma = cmsBuildGamma(nullptr, 563.0 / 256.0);
  const std::array<cmsToneCurve*, 3> curves{gamma, gamma, gamma};
  std::string bytes = bytes_of_profile(cmsCreateRGBProfile(&white, &primaries, curves.data()));
  cmsFreeToneCurve(gamma);
  return bytes;
}

// The same colour by the definitions of both spaces: linear by the gamma, the matrices of Adobe RGB
// (1998), 4.3.5.3 and IEC 61966-2-1, and sRGB's curve.
cv::Vec3b srgb_of_adobe(const cv::Vec3b& bgr) {
  const cv::Matx33d xyz_from_adobe(0.57667, 0.18556, 0.18823, 0.29734, 0.62736, 0.07529, 0.02703,
                                   0.07069, 0.99134);
  const cv::Matx33d srgb_from_xyz(3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557,
                                  -0.2040, 1.0570);
  const auto linear = [](uchar level) { return std::pow(level / 255.0, 563.0 / 256.0); };
  const cv::Vec3d rgb =
      srgb_from_xyz * (xyz_from_adobe * cv::Vec3d(linear(bgr[2]), linear(bgr[1]), linear(bgr[0])));
  const auto level = [](double value) {
    const double x = std::clamp(value, 0.0, 1.0);
    const double curved = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return cv::saturate_cast<uchar>(255.0 * curved);
  };
  return {level(rgb[2]), level(rgb[1]), level(rgb[0])};
}

cv::Mat noise() {
  cv::Mat picture(32, 64, CV_8UC3);
  cv::theRNG().state = 5;
  cv::randu(picture, cv::Scalar::all(0), cv::Scalar::all(255));
  return picture;
}

std::string png_with_profile(const std::string& profile) {
  std::string packed(compressBound(profile.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(profile.data()), profile.size());
  packed.resize(size);
  const std::string data = std::string("iCCPname\0\0", 10) + packed;
  const auto big_endian = [](std::size_t value) {
    std::string bytes;
    for (int i = 3; i >= 0; --i) bytes.push_back(static_cast<char>(value >> (8 * i)));
    return bytes;
  };
  const std::string chunk =
      big_endian(data.size() - 4) + data +
      big_endian(crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size()));
  const auto png = encode_image("a.png", noise());
  return std::string(png.begin(), png.end()).insert(33, chunk);  // behind IHDR
}

// In two pieces, the second one first.
std::string jpeg_with_profile(const std::string& profile) {
  const auto segment = [&](char number, const std::string& piece) {
    const std::size_t length = 2 + 14 + piece.size();
    return std::string("\xFF\xE2") + static_cast<char>(length >> 8) +
           static_cast<char>(length & 0xFF) + std::string("ICC_PROFILE\0", 12) + number + '\2' +
           piece;
  };
  const auto jpeg = encode_jpeg(noise(), 100);
  std::string bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  return bytes.insert(2,
                      segment('\2', profile.substr(200)) + segment('\1', profile.substr(0, 200)));
}

TEST(ColourProfile, APictureInAnotherColourSpaceIsReadAsSrgb) {
  const TestDirectory directory;
  for (const bool is_jpeg : {false, true}) {
    const auto file = directory / (is_jpeg ? "a.jpg" : "a.png"), plain = directory / "plain.jpg";
    write_file_atomically(file,
                          is_jpeg ? jpeg_with_profile(adobe_rgb()) : png_with_profile(adobe_rgb()));
    cv::Mat stored = noise();
    if (is_jpeg) {
      const auto jpeg = encode_jpeg(noise(), 100);
      write_file_atomically(plain, std::span<const std::byte>(jpeg));
      stored = read_panorama(plain);
    }
    const cv::Mat read = read_panorama(file);
    double largest = 0.0, changed = 0.0;
    for (int i = 0; i < static_cast<int>(stored.total()); ++i) {
      const cv::Vec3b expected = srgb_of_adobe(stored.at<cv::Vec3b>(i));
      largest = std::max(largest, cv::norm(read.at<cv::Vec3b>(i), expected, cv::NORM_INF));
      changed = std::max(changed, cv::norm(stored.at<cv::Vec3b>(i), expected, cv::NORM_INF));
    }
    EXPECT_GT(changed, 30.0) << "the test's colours are too pale";
    EXPECT_LE(largest, 2.0) << is_jpeg;
  }
}

TEST(ColourProfile, SrgbDamagedAndOtherProfilesChangeNothing) {
  cmsToneCurve* gamma = cmsBuildGamma(nullptr, 1.8);
  const std::string grey = bytes_of_profile(cmsCreateGrayProfile(cmsD50_xyY(), gamma));
  cmsFreeToneCurve(gamma);
  const std::string srgb = bytes_of_profile(cmsCreate_sRGBProfile()), adobe = adobe_rgb();
  for (const std::string& profile :
       {std::string(), srgb, grey, adobe.substr(0, 100), std::string(500, 'x')}) {
    cv::Mat picture = noise();
    convert_to_srgb(profile, &picture);
    EXPECT_EQ(cv::norm(picture, noise(), cv::NORM_INF), 0.0) << profile.size();
  }
}

TEST(ColourProfile, CutAndDamagedFilesHaveAProfileOrNone) {
  for (const std::string& whole : {jpeg_with_profile(adobe_rgb()), png_with_profile(adobe_rgb())}) {
    EXPECT_EQ(embedded_profile(std::as_bytes(std::span(whole))), adobe_rgb());
    const std::size_t end = std::min<std::size_t>(whole.size(), 1000);
    for (std::size_t at = 2; at < end; ++at) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
      embedded_profile(std::as_bytes(std::span(bytes)));
      embedded_profile(std::as_bytes(std::span(whole).first(at)));
    }
  }
}

}  // namespace
}  // namespace raywalk
