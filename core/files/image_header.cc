#include "core/files/image_header.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace raywalk {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::array<std::uint8_t, 3> kJpegSignature = {0xFF, 0xD8, 0xFF};

std::uint8_t byte_at(Bytes bytes, std::size_t index) {
  return std::to_integer<std::uint8_t>(bytes[index]);
}

// Big-endian, as both formats store numbers.
std::uint32_t uint16_at(Bytes bytes, std::size_t index) {
  return static_cast<std::uint32_t>(byte_at(bytes, index) << 8 | byte_at(bytes, index + 1));
}

std::uint32_t uint32_at(Bytes bytes, std::size_t index) {
  return uint16_at(bytes, index) << 16 | uint16_at(bytes, index + 2);
}

// Compares only the available `bytes`: a file that ends within its signature is truncated, not of
// another format.
template <std::size_t N>
bool starts_like(Bytes bytes, const std::array<std::uint8_t, N>& signature) {
  for (std::size_t i = 0; i < std::min(N, bytes.size()); ++i) {
    if (byte_at(bytes, i) != signature[i]) return false;
  }
  return true;
}

// --- EXIF ---------------------------------------------------------------------------------------

constexpr std::uint32_t kOrientationTag = 0x0112;
constexpr std::uint32_t kShortType = 3;
constexpr int kUpright = 1;
constexpr std::uint32_t kLargestOrientation = 8;
constexpr std::size_t kTiffHeaderBytes = 8;
constexpr std::size_t kEntryBytes = 12;

// Numbers of a TIFF block, which gives its own byte order.
class TiffReader {
 public:
  explicit TiffReader(Bytes tiff) : tiff_(tiff), little_(byte_at(tiff, 0) == 'I') {}

  bool holds(std::size_t index, std::size_t count) const {
    return index <= tiff_.size() && count <= tiff_.size() - index;
  }
  std::uint32_t uint16(std::size_t index) const {
    const std::uint32_t value = uint16_at(tiff_, index);
    return little_ ? (value & 0xFF) << 8 | value >> 8 : value;
  }
  std::uint32_t uint32(std::size_t index) const {
    return little_ ? uint16(index + 2) << 16 | uint16(index) : uint32_at(tiff_, index);
  }

 private:
  Bytes tiff_;
  bool little_;
};

// The orientation in the first directory of a TIFF block; upright if it has none or is damaged. The
// header is byte order, 2 bytes; 42, 2; offset of the directory, 4. A directory is its number of
// entries, 2 bytes, and entries: tag, 2; type, 2; count, 4; value, 4.
int orientation_in(Bytes bytes) {
  if (bytes.size() < kTiffHeaderBytes) return kUpright;
  const TiffReader tiff(bytes);
  const std::size_t directory = tiff.uint32(4);
  if (!tiff.holds(directory, 2)) return kUpright;
  const std::size_t entries = tiff.uint16(directory);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + i * kEntryBytes;
    if (!tiff.holds(entry, kEntryBytes)) return kUpright;
    if (tiff.uint16(entry) != kOrientationTag || tiff.uint16(entry + 2) != kShortType) continue;
    const std::uint32_t value = tiff.uint16(entry + 8);
    return value >= 1 && value <= kLargestOrientation ? static_cast<int>(value) : kUpright;
  }
  return kUpright;
}

// --- JPEG ---------------------------------------------------------------------------------------

constexpr std::uint8_t kEndOfImage = 0xD9;
constexpr std::uint8_t kStartOfScan = 0xDA;

// Markers without a length and a payload: TEM, RST0..RST7 and SOI (T.81, table B.1).
bool is_standalone(std::uint8_t marker) {
  return marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
}

// SOF0..SOF15 except DHT (C4), JPG (C8) and DAC (CC), which share their range.
bool is_start_of_frame(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

// One marker segment; `payload` excludes marker and length.
struct JpegSegment {
  std::uint8_t marker = 0;
  Bytes payload;
};

// Walks the marker segments of a JPEG stream.
class JpegWalker {
 public:
  explicit JpegWalker(Bytes bytes) : bytes_(bytes) {}

  // The next segment; none at the end of the bytes. Bytes before its 0xFF (entropy-coded data,
  // stray bytes) are skipped: in entropy-coded data 0xFF is followed by 0 (T.81, F.1.2.3), so 0xFF
  // with anything but 0 or another 0xFF (fill, B.1.1.2) is a marker.
  std::optional<JpegSegment> next() {
    while (position_ + 1 < bytes_.size()) {
      const std::uint8_t first = byte_at(bytes_, position_);
      const std::uint8_t second = byte_at(bytes_, position_ + 1);
      if (first != 0xFF || second == 0xFF) {
        ++position_;
        continue;
      }
      position_ += 2;
      if (second == 0 || is_standalone(second)) continue;
      if (second == kEndOfImage) return JpegSegment{second, {}};
      return segment(second);
    }
    return std::nullopt;
  }

 private:
  // The length counts its own two bytes (B.1.1.4).
  std::optional<JpegSegment> segment(std::uint8_t marker) {
    if (bytes_.size() - position_ < 2) return std::nullopt;
    const std::size_t length = std::max<std::size_t>(uint16_at(bytes_, position_), 2);
    if (bytes_.size() - position_ < length) return std::nullopt;
    const Bytes payload = bytes_.subspan(position_ + 2, length - 2);
    position_ += length;
    return JpegSegment{marker, payload};
  }

  Bytes bytes_;
  std::size_t position_ = kJpegSignature.size() - 1;  // at the first segment's 0xFF
};

// The TIFF block of an EXIF segment: APP1 that begins with "Exif", 0, 0.
std::optional<Bytes> exif_of(const JpegSegment& segment) {
  constexpr std::uint8_t kApp1 = 0xE1;
  constexpr std::array<std::uint8_t, 6> kExif = {'E', 'x', 'i', 'f', 0, 0};
  if (segment.marker != kApp1 || segment.payload.size() < kExif.size()) return std::nullopt;
  if (!starts_like(segment.payload, kExif)) return std::nullopt;
  return segment.payload.subspan(kExif.size());
}

// Frame header (B.2.2): precision, 1 byte; lines, 2; samples per line, 2; components, 1.
ImageHeader jpeg_header_from_frame(Bytes payload, const std::string& source) {
  if (payload.size() < 6) throw Error(source + ": damaged JPEG (its frame header is too short)");
  ImageHeader header;
  header.format = ImageFormat::kJpeg;
  header.bits_per_channel = byte_at(payload, 0);
  header.height = uint16_at(payload, 1);
  header.width = uint16_at(payload, 3);
  header.is_grey = byte_at(payload, 5) == 1;
  return header;
}

std::optional<ImageHeader> parse_jpeg_header(Bytes bytes, const std::string& source) {
  JpegWalker walker(bytes);
  int orientation = 1;
  while (const auto segment = walker.next()) {
    if (const auto tiff = exif_of(*segment)) orientation = orientation_in(*tiff);
    if (is_start_of_frame(segment->marker)) {
      ImageHeader header = jpeg_header_from_frame(segment->payload, source);
      header.orientation = orientation;
      return header;
    }
    if (segment->marker == kStartOfScan || segment->marker == kEndOfImage) {
      throw Error(source + ": damaged JPEG (no frame header before its data)");
    }
  }
  return std::nullopt;
}

bool is_complete_jpeg(Bytes bytes) {
  JpegWalker walker(bytes);
  while (const auto segment = walker.next()) {
    if (segment->marker == kEndOfImage) return true;
  }
  return false;
}

// --- PNG ----------------------------------------------------------------------------------------

// A chunk: length of its data, 4 bytes; type, 4; data; CRC, 4 (section 5.3).
constexpr std::size_t kChunkOverhead = 12;
constexpr std::uint32_t kIhdr = 0x49484452;
constexpr std::uint32_t kIend = 0x49454E44;
constexpr std::size_t kIhdrDataBytes = 13;

// From the eXIf chunk, if it comes before the pixels and is held whole by `chunks`.
int png_orientation(Bytes chunks) {
  constexpr std::uint32_t kExif = 0x65584966, kIdat = 0x49444154;
  while (chunks.size() >= kChunkOverhead) {
    const std::size_t data_bytes = uint32_at(chunks, 0);
    if (chunks.size() - kChunkOverhead < data_bytes || uint32_at(chunks, 4) == kIdat) break;
    if (uint32_at(chunks, 4) == kExif) return orientation_in(chunks.subspan(8, data_bytes));
    chunks = chunks.subspan(kChunkOverhead + data_bytes);
  }
  return kUpright;
}

// IHDR's data (section 11.2.2): width, 4 bytes; height, 4; bit depth, 1; colour type, 1 (0 = grey).
std::optional<ImageHeader> parse_png_header(Bytes bytes, const std::string& source) {
  if (bytes.size() < kPngSignature.size() + kChunkOverhead + kIhdrDataBytes) return std::nullopt;
  const Bytes chunk = bytes.subspan(kPngSignature.size());
  if (uint32_at(chunk, 0) != kIhdrDataBytes || uint32_at(chunk, 4) != kIhdr) {
    throw Error(source + ": damaged PNG (it does not begin with its header)");
  }
  ImageHeader header;
  header.format = ImageFormat::kPng;
  header.width = uint32_at(chunk, 8);
  header.height = uint32_at(chunk, 12);
  header.bits_per_channel = byte_at(chunk, 16);
  header.is_grey = byte_at(chunk, 17) == 0;
  header.orientation = png_orientation(chunk);
  return header;
}

bool is_complete_png(Bytes bytes) {
  Bytes rest = bytes.subspan(std::min(kPngSignature.size(), bytes.size()));
  while (rest.size() >= kChunkOverhead) {
    const std::size_t chunk_bytes = kChunkOverhead + std::size_t{uint32_at(rest, 0)};
    if (rest.size() < chunk_bytes) return false;
    if (uint32_at(rest, 4) == kIend) return true;
    rest = rest.subspan(chunk_bytes);
  }
  return false;
}

}  // namespace

std::optional<ImageHeader> parse_image_header(Bytes bytes, const std::string& source) {
  if (bytes.empty()) throw Error(source + ": empty file; capture or copy it again");
  std::optional<ImageHeader> header;
  if (starts_like(bytes, kJpegSignature)) {
    header = parse_jpeg_header(bytes, source);
  } else if (starts_like(bytes, kPngSignature)) {
    header = parse_png_header(bytes, source);
  } else {
    throw Error(source + ": not an image Raywalk reads; JPEG or PNG is needed");
  }
  if (header && (header->width < 1 || header->height < 1)) {
    throw Error(source + ": its header gives the size " + std::to_string(header->width) + "x" +
                std::to_string(header->height) + "; capture or copy it again");
  }
  return header;
}

bool is_complete_image(Bytes bytes, ImageFormat format) {
  return format == ImageFormat::kJpeg ? is_complete_jpeg(bytes) : is_complete_png(bytes);
}

}  // namespace raywalk
