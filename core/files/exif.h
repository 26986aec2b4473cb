// Exif tags (Exif 2.32, CIPA DC-008): read with libexif, written as a TIFF block.
#pragma once

#include <libexif/exif-data.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

// The tags of an image. Anything missing, damaged or of another type reads as not there.
class ExifTags {
 public:
  // Of a JPEG or PNG file, or as much of its beginning as holds them.
  explicit ExifTags(std::span<const std::byte> image);

  // Of the image or its exposure. Text comes without the blanks and zeros that pad it.
  std::string text(ExifTag tag) const;
  std::optional<double> number(ExifTag tag) const;  // a SHORT or RATIONAL, the first if several

 private:
  const ExifEntry* find(ExifTag tag) const;

  std::unique_ptr<ExifData, void (*)(ExifData*)> data_;
};

// An entry of a TIFF directory (TIFF 6.0, section 2), with its value in little-endian bytes.
struct TiffEntry {
  std::uint16_t tag = 0;
  std::uint16_t type = 0;
  std::uint32_t count = 0;
  std::string value{};
};

TiffEntry ascii_entry(int tag, const std::string& text);
TiffEntry short_entry(int tag, std::uint16_t value);
TiffEntry long_entry(int tag, std::uint32_t value);
TiffEntry rational_entry(int tag, std::uint32_t numerator, std::uint32_t denominator);
TiffEntry bytes_entry(int tag, std::string bytes);
std::string little_endian(std::uint64_t value, int bytes);

// A directory that begins at the even position `at` of its file, with the values that it points to
// behind it.
std::string tiff_directory(std::vector<TiffEntry> entries, std::size_t at);

// The TIFF block of an Exif segment or chunk: entries of the image, and those of its exposure.
std::string exif_block(std::vector<TiffEntry> image, std::vector<TiffEntry> exposure);

// A JPEG file with a segment of application data (APP1) added: `identifier` and `data`, at most
// 65,533 bytes together.
std::string with_app1(const std::string& jpeg, const std::string& identifier,
                      const std::string& data);
inline const std::string kExifIdentifier{"Exif\0\0", 6};

}  // namespace raywalk
