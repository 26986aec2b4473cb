#include "core/room/tile_codec.h"

#include <turbojpeg.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <new>

namespace raywalk {
namespace {

// Packing takes a little longer than with level 1, for a tenth of the size on smooth pictures;
// decoding takes as long.
constexpr int kZstdLevel = 6;
constexpr std::size_t kCrcBytes = 4;

// A tile's planes follow each other: green, red and blue.
void split_colours(const std::uint8_t* __restrict rgb, std::size_t pixels, std::uint8_t* planes) {
  std::uint8_t* __restrict green = planes;
  std::uint8_t* __restrict red = planes + pixels;
  std::uint8_t* __restrict blue = planes + 2 * pixels;
  for (std::size_t i = 0; i < pixels; ++i) {
    green[i] = rgb[3 * i + 1];
    red[i] = static_cast<std::uint8_t>(rgb[3 * i] - green[i]);
    blue[i] = static_cast<std::uint8_t>(rgb[3 * i + 2] - green[i]);
  }
}

void join_colours(const std::uint8_t* planes, std::size_t pixels, std::uint8_t* __restrict rgb) {
  const std::uint8_t* __restrict green = planes;
  const std::uint8_t* __restrict red = planes + pixels;
  const std::uint8_t* __restrict blue = planes + 2 * pixels;
  for (std::size_t i = 0; i < pixels; ++i) {
    rgb[3 * i] = static_cast<std::uint8_t>(red[i] + green[i]);
    rgb[3 * i + 1] = green[i];
    rgb[3 * i + 2] = static_cast<std::uint8_t>(blue[i] + green[i]);
  }
}

// From the last pixel on, so that those before are still there.
void take_differences(std::uint8_t* plane, TileSize size) {
  const auto rows = static_cast<std::size_t>(size.rows);
  for (auto column = static_cast<std::size_t>(size.columns); column-- > 1;) {
    std::uint8_t* __restrict at = plane + column * rows;
    const std::uint8_t* __restrict before = at - rows;
    for (std::size_t row = 0; row < rows; ++row) {
      at[row] = static_cast<std::uint8_t>(at[row] - before[row]);
    }
  }
  for (std::size_t row = rows; row-- > 1;) {
    plane[row] = static_cast<std::uint8_t>(plane[row] - plane[row - 1]);
  }
}

void undo_differences(std::uint8_t* plane, TileSize size) {
  const auto rows = static_cast<std::size_t>(size.rows);
  for (std::size_t row = 1; row < rows; ++row) {
    plane[row] = static_cast<std::uint8_t>(plane[row] + plane[row - 1]);
  }
  for (std::size_t column = 1; column < static_cast<std::size_t>(size.columns); ++column) {
    std::uint8_t* __restrict at = plane + column * rows;
    const std::uint8_t* __restrict before = at - rows;
    for (std::size_t row = 0; row < rows; ++row) {
      at[row] = static_cast<std::uint8_t>(at[row] + before[row]);
    }
  }
}

std::vector<std::uint8_t> encode_lossless(TileSize size, const std::uint8_t* rgb) {
  std::vector<std::uint8_t> differences(size.bytes());
  const std::size_t pixels = size.bytes() / 3;
  split_colours(rgb, pixels, differences.data());
  for (std::size_t i = 0; i < 3; ++i) take_differences(differences.data() + i * pixels, size);
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                     ZSTD_freeCCtx);
  if (!context) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kZstdLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::vector<std::uint8_t> encoded(ZSTD_compressBound(differences.size()));
  const std::size_t bytes = ZSTD_compress2(context.get(), encoded.data(), encoded.size(),
                                           differences.data(), differences.size());
  if (ZSTD_isError(bytes) != 0) throw std::bad_alloc();  // the only failure with this much space
  encoded.resize(bytes);
  return encoded;
}

// What decoding needs besides its result; a thread keeps it.
struct LosslessScratch {
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context{ZSTD_createDCtx(), ZSTD_freeDCtx};
  std::vector<std::uint8_t> differences;
};

bool decode_lossless(TileSize size, std::span<const std::uint8_t> encoded, std::uint8_t* rgb) {
  thread_local LosslessScratch scratch;
  if (!scratch.context) throw std::bad_alloc();
  scratch.differences.resize(std::max(scratch.differences.size(), size.bytes()));
  if (ZSTD_decompressDCtx(scratch.context.get(), scratch.differences.data(), size.bytes(),
                          encoded.data(), encoded.size()) != size.bytes()) {
    return false;
  }
  const std::size_t pixels = size.bytes() / 3;
  std::uint8_t* const planes = scratch.differences.data();
  for (std::size_t i = 0; i < 3; ++i) undo_differences(planes + i * pixels, size);
  join_colours(planes, pixels, rgb);
  return true;
}

// Little-endian, as the machine.
std::array<std::uint8_t, kCrcBytes> crc_of(std::span<const std::uint8_t> bytes) {
  return std::bit_cast<std::array<std::uint8_t, kCrcBytes>>(
      static_cast<std::uint32_t>(::crc32(0, bytes.data(), static_cast<uInt>(bytes.size()))));
}

// TurboJPEG's handle of a compression or decompression.
using JpegHandle = std::unique_ptr<void, decltype(&tjDestroy)>;

std::vector<std::uint8_t> encode_as_jpeg(TileSize size, const std::uint8_t* rgb, int quality) {
  const JpegHandle handle(tjInitCompress(), tjDestroy);
  std::vector<std::uint8_t> encoded(kCrcBytes + tjBufSize(size.rows, size.columns, TJSAMP_444));
  unsigned char* jpeg = encoded.data() + kCrcBytes;
  unsigned long bytes = encoded.size() - kCrcBytes;  // NOLINT(google-runtime-int): TurboJPEG's type
  if (!handle || tjCompress2(handle.get(), rgb, size.rows, 0, size.columns, TJPF_RGB, &jpeg, &bytes,
                             TJSAMP_444, quality, TJFLAG_NOREALLOC | TJFLAG_ACCURATEDCT) != 0) {
    throw std::bad_alloc();  // its only error here
  }
  encoded.resize(kCrcBytes + bytes);
  std::ranges::copy(crc_of(std::span(encoded).subspan(kCrcBytes)), encoded.begin());
  return encoded;
}

bool decode_jpeg_tile(TileSize size, std::span<const std::uint8_t> encoded, std::uint8_t* rgb) {
  if (encoded.size() < kCrcBytes) return false;
  const std::span<const std::uint8_t> jpeg = encoded.subspan(kCrcBytes);
  if (!std::ranges::equal(crc_of(jpeg), encoded.first(kCrcBytes))) return false;
  thread_local const JpegHandle handle(tjInitDecompress(), tjDestroy);
  if (!handle) throw std::bad_alloc();
  int width = 0, height = 0, sampling = 0, colours = 0;
  return tjDecompressHeader3(handle.get(), jpeg.data(), jpeg.size(), &width, &height, &sampling,
                             &colours) == 0 &&
         width == size.rows && height == size.columns &&
         tjDecompress2(handle.get(), jpeg.data(), jpeg.size(), rgb, width, 0, height, TJPF_RGB,
                       TJFLAG_ACCURATEDCT) == 0;
}

}  // namespace

std::vector<std::uint8_t> encode_tile(const RayForm& form, TileSize size, const std::uint8_t* rgb) {
  if (form.kind == RayForm::Kind::kJpeg) return encode_as_jpeg(size, rgb, form.jpeg_quality);
  return encode_lossless(size, rgb);
}

bool decode_tile(RayForm::Kind kind, TileSize size, std::span<const std::uint8_t> encoded,
                 std::uint8_t* rgb) {
  if (kind == RayForm::Kind::kJpeg) return decode_jpeg_tile(size, encoded, rgb);
  return decode_lossless(size, encoded, rgb);
}

}  // namespace raywalk
