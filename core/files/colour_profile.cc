#include "core/files/colour_profile.h"

#include <lcms2.h>
#include <zlib.h>

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string_view>
#include <type_traits>

#include "core/files/png.h"

namespace raywalk {
namespace {

using ProfileHandle = std::unique_ptr<void, decltype(&cmsCloseProfile)>;
using TransformHandle = std::unique_ptr<void, decltype(&cmsDeleteTransform)>;
constexpr std::size_t kLargestProfile = std::size_t{16} << 20;  // printers' have some 2 MB

// A profile may be longer than a segment: each piece, behind its identifier, begins with its number
// from 1 and the number of all.
std::string jpeg_profile(std::string_view text) {
  const std::string_view identifier("ICC_PROFILE\0", 12);
  std::map<std::uint8_t, std::string_view> pieces;
  std::uint8_t count = 0;
  const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(text[at]); };
  for (std::size_t at = 2; at + 4 <= text.size() && byte(at) == 0xFF && byte(at + 1) != 0xDA;) {
    const std::size_t length = byte(at + 2) * std::size_t{256} + byte(at + 3);
    const std::string_view segment = text.substr(at + 4, length < 2 ? 0 : length - 2);
    if (byte(at + 1) == 0xE2 && segment.starts_with(identifier) && segment.size() > 14) {
      count = static_cast<std::uint8_t>(segment[13]);
      pieces[static_cast<std::uint8_t>(segment[12])] = segment.substr(14);
    }
    at += 2 + length;
  }
  std::string profile;
  if (pieces.size() != count) return profile;
  for (const auto& [number, piece] : pieces) profile += piece;
  return profile;
}

// A name that ends in a zero, the method of compression, 1 byte: always 0, and the data.
std::string png_profile(std::string_view chunk) {
  const std::size_t name_end = chunk.find('\0');
  if (name_end == std::string_view::npos || chunk.size() < name_end + 2) return {};
  const std::string_view packed = chunk.substr(name_end + 2);
  for (std::size_t size = 4 * packed.size() + 1024; size <= kLargestProfile; size *= 4) {
    std::string profile(size, '\0');
    uLongf unpacked = size;
    const int result = uncompress(reinterpret_cast<Bytef*>(profile.data()), &unpacked,
                                  reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    profile.resize(unpacked);
    if (result == Z_OK) return profile;
    if (result != Z_BUF_ERROR) break;
  }
  return {};
}

void transform(cmsHTRANSFORM how, cv::Mat* image) {
  for (int row = 0; row < image->rows; ++row) {
    cmsDoTransform(how, image->ptr(row), image->ptr(row), static_cast<unsigned>(image->cols));
  }
}

// By 17 levels of each channel.
bool changes_colours(cmsHTRANSFORM how) {
  constexpr int kLevels = 17, kStep = 15;
  cv::Mat colours(kLevels * kLevels, kLevels, CV_8UC3);
  for (int i = 0; i < colours.rows; ++i) {
    for (int j = 0; j < kLevels; ++j) {
      colours.at<cv::Vec3b>(i, j) =
          cv::Vec3b(static_cast<uchar>(i / kLevels * kStep),
                    static_cast<uchar>(i % kLevels * kStep), static_cast<uchar>(j * kStep));
    }
  }
  cv::Mat changed = colours.clone();
  transform(how, &changed);
  return cv::norm(changed, colours, cv::NORM_INF) > 1.0;
}

}  // namespace

std::string embedded_profile(std::span<const std::byte> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  return text.starts_with("\xFF\xD8") ? jpeg_profile(text) : png_profile(png_chunk(file, "iCCP"));
}

void convert_to_srgb(const std::string& profile, cv::Mat* image) {
  if (profile.empty()) return;
  const ProfileHandle from(
      cmsOpenProfileFromMem(profile.data(), static_cast<cmsUInt32Number>(profile.size())),
      cmsCloseProfile);
  if (!from || cmsGetColorSpace(from.get()) != cmsSigRgbData) return;
  const ProfileHandle srgb(cmsCreate_sRGBProfile(), cmsCloseProfile);
  const TransformHandle how(cmsCreateTransform(from.get(), TYPE_BGR_8, srgb.get(), TYPE_BGR_8,
                                               INTENT_RELATIVE_COLORIMETRIC, 0),
                            cmsDeleteTransform);
  if (how && changes_colours(how.get())) transform(how.get(), image);
}

}  // namespace raywalk
