#include "core/files/exif.h"

#include <libexif/exif-utils.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace raywalk {
namespace {

constexpr int kByte = 1, kAscii = 2, kShort = 3, kLong = 4, kRational = 5;  // types of TIFF 6.0
constexpr std::size_t kTiffHeaderBytes = 8;

// What libexif reads: a JPEG file as it is, the chunk eXIf of a PNG file as a JPEG segment has it.
std::string for_libexif(std::span<const std::byte> image) {
  const std::string_view text(reinterpret_cast<const char*>(image.data()), image.size());
  if (text.starts_with("\xFF\xD8")) return std::string(text);
  const std::size_t chunk = std::min(text.find("eXIf"), text.find("IDAT"));
  if (chunk == std::string_view::npos || text[chunk] != 'e') return {};
  return kExifIdentifier + std::string(text.substr(chunk + 4));
}

}  // namespace

ExifTags::ExifTags(std::span<const std::byte> image) : data_(exif_data_new(), exif_data_unref) {
  constexpr std::size_t kLongest = std::size_t{1}
                                   << 20;  // many times what a file has before pixels
  const std::string bytes = for_libexif(image.first(std::min(image.size(), kLongest)));
  if (!data_ || bytes.empty()) return;
  // It would otherwise add what the specification demands.
  exif_data_unset_option(data_.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(data_.get(), reinterpret_cast<const unsigned char*>(bytes.data()),
                      static_cast<unsigned int>(bytes.size()));
}

const ExifEntry* ExifTags::find(ExifTag tag) const {
  for (const ExifIfd directory : {EXIF_IFD_0, EXIF_IFD_EXIF}) {
    if (!data_) return nullptr;
    const ExifEntry* entry = exif_content_get_entry(data_->ifd[directory], tag);
    if (entry != nullptr && entry->data != nullptr) return entry;
  }
  return nullptr;
}

std::string ExifTags::text(ExifTag tag) const {
  const ExifEntry* entry = find(tag);
  if (entry == nullptr || entry->format != EXIF_FORMAT_ASCII) return {};
  std::string text(reinterpret_cast<const char*>(entry->data), entry->size);
  const auto last = text.find_last_not_of(std::string_view(" \0", 2));
  text.erase(last == std::string::npos ? 0 : last + 1);
  return text;
}

std::optional<double> ExifTags::number(ExifTag tag) const {
  const ExifEntry* entry = find(tag);
  if (entry == nullptr || entry->size < exif_format_get_size(entry->format)) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(data_.get());
  if (entry->format == EXIF_FORMAT_SHORT) return exif_get_short(entry->data, order);
  if (entry->format != EXIF_FORMAT_RATIONAL) return std::nullopt;
  const ExifRational value = exif_get_rational(entry->data, order);
  if (value.denominator == 0) return std::nullopt;
  return static_cast<double>(value.numerator) / value.denominator;
}

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(static_cast<char>(value >> (8 * i)));
  return text;
}

TiffEntry ascii_entry(int tag, const std::string& text) {
  return {static_cast<std::uint16_t>(tag), kAscii, static_cast<std::uint32_t>(text.size() + 1),
          text + '\0'};
}

TiffEntry short_entry(int tag, std::uint16_t value) {
  return {static_cast<std::uint16_t>(tag), kShort, 1, little_endian(value, 2)};
}

TiffEntry long_entry(int tag, std::uint32_t value) {
  return {static_cast<std::uint16_t>(tag), kLong, 1, little_endian(value, 4)};
}

TiffEntry rational_entry(int tag, std::uint32_t numerator, std::uint32_t denominator) {
  return {static_cast<std::uint16_t>(tag), kRational, 1,
          little_endian(numerator, 4) + little_endian(denominator, 4)};
}

TiffEntry bytes_entry(int tag, std::string bytes) {
  const auto count = static_cast<std::uint32_t>(bytes.size());
  return {static_cast<std::uint16_t>(tag), kByte, count, std::move(bytes)};
}

// The number of entries, 2 bytes; entries by tag: tag, 2; type, 2; count, 4; value or its position,
// 4; and the position of the next directory, 4: none.
std::string tiff_directory(std::vector<TiffEntry> entries, std::size_t at) {
  std::ranges::sort(entries, {}, &TiffEntry::tag);
  std::string directory = little_endian(entries.size(), 2), values;
  const std::size_t values_at = at + 2 + 12 * entries.size() + 4;
  for (const TiffEntry& entry : entries) {
    directory += little_endian(entry.tag, 2) + little_endian(entry.type, 2);
    directory += little_endian(entry.count, 4);
    std::string value = entry.value;
    if (value.size() <= 4) {
      value.resize(4);
      directory += value;
    } else {
      directory += little_endian(values_at + values.size(), 4);
      value.resize((value.size() + 1) / 2 * 2);  // positions are even
      values += value;
    }
  }
  return directory + little_endian(0, 4) + values;
}

std::string exif_block(std::vector<TiffEntry> image, std::vector<TiffEntry> exposure) {
  const std::string header = std::string("II*\0", 4) + little_endian(kTiffHeaderBytes, 4);
  if (exposure.empty()) return header + tiff_directory(std::move(image), kTiffHeaderBytes);
  image.push_back(long_entry(EXIF_TAG_EXIF_IFD_POINTER, 0));
  const std::size_t exposure_at = kTiffHeaderBytes + tiff_directory(image, kTiffHeaderBytes).size();
  image.back() = long_entry(EXIF_TAG_EXIF_IFD_POINTER, static_cast<std::uint32_t>(exposure_at));
  return header + tiff_directory(std::move(image), kTiffHeaderBytes) +
         tiff_directory(std::move(exposure), exposure_at);
}

std::string with_app1(const std::string& jpeg, const std::string& identifier,
                      const std::string& data) {
  const std::size_t length = 2 + identifier.size() + data.size();  // counts its own bytes
  return jpeg.substr(0, 2) + "\xFF\xE1" + static_cast<char>(length >> 8) +
         static_cast<char>(length & 0xFF) + identifier + data + jpeg.substr(2);
}

}  // namespace raywalk
