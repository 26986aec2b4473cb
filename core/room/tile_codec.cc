#include "core/room/tile_codec.h"

#include <jerror.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <new>

#include "core/files/jpeg_errors.h"

namespace raywalk {
namespace {

// Packing takes a little longer than with level 1, for a tenth of the size on smooth pictures;
// decoding takes as long.
constexpr int kZstdLevel = 6;
constexpr std::size_t kCrcBytes = 4;

// The three planes of a tile.
struct Planes {
  std::uint8_t* green;
  std::uint8_t* red;
  std::uint8_t* blue;
};

Planes planes_of(std::uint8_t* first, TileSize size) {
  const std::size_t pixels = size.bytes() / 3;
  return {first, first + pixels, first + 2 * pixels};
}

void split_colours(const std::uint8_t* __restrict rgb, std::size_t pixels, Planes planes) {
  std::uint8_t* __restrict green = planes.green;
  std::uint8_t* __restrict red = planes.red;
  std::uint8_t* __restrict blue = planes.blue;
  for (std::size_t i = 0; i < pixels; ++i) {
    green[i] = rgb[3 * i + 1];
    red[i] = static_cast<std::uint8_t>(rgb[3 * i] - green[i]);
    blue[i] = static_cast<std::uint8_t>(rgb[3 * i + 2] - green[i]);
  }
}

void join_colours(Planes planes, std::size_t pixels, std::uint8_t* __restrict rgb) {
  const std::uint8_t* __restrict green = planes.green;
  const std::uint8_t* __restrict red = planes.red;
  const std::uint8_t* __restrict blue = planes.blue;
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
  const Planes planes = planes_of(differences.data(), size);
  split_colours(rgb, size.bytes() / 3, planes);
  for (std::uint8_t* plane : {planes.green, planes.red, planes.blue}) take_differences(plane, size);
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
  const Planes planes = planes_of(scratch.differences.data(), size);
  for (std::uint8_t* plane : {planes.green, planes.red, planes.blue}) undo_differences(plane, size);
  join_colours(planes, size.bytes() / 3, rgb);
  return true;
}

// One compression into memory of its own. The functions of this class and the next return false on
// an error of libjpeg.
class TileEncoder {
 public:
  TileEncoder() { info_.err = prepare(&trap_); }
  ~TileEncoder() {
    jpeg_destroy_compress(&info_);
    std::free(bytes_);
  }
  TileEncoder(const TileEncoder&) = delete;
  TileEncoder& operator=(const TileEncoder&) = delete;

  bool encode(TileSize size, const std::uint8_t* rgb, int quality) {
    if (setjmp(trap_.start) != 0) return false;
    jpeg_create_compress(&info_);
    jpeg_mem_dest(&info_, &bytes_, &size_);
    info_.image_width = static_cast<JDIMENSION>(size.rows);
    info_.image_height = static_cast<JDIMENSION>(size.columns);
    info_.input_components = 3;
    info_.in_color_space = JCS_RGB;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    info_.optimize_coding = TRUE;
    for (int i = 0; i < info_.num_components; ++i) {
      info_.comp_info[i].h_samp_factor = info_.comp_info[i].v_samp_factor = 1;
    }
    jpeg_start_compress(&info_, TRUE);
    while (info_.next_scanline < info_.image_height) {
      // libjpeg does not write to it.
      auto* column = const_cast<std::uint8_t*>(rgb) +
                     3 * static_cast<std::size_t>(size.rows) * info_.next_scanline;
      jpeg_write_scanlines(&info_, &column, 1);
    }
    jpeg_finish_compress(&info_);
    return true;
  }

  std::span<const std::uint8_t> bytes() const { return {bytes_, size_}; }

 private:
  jpeg_compress_struct info_{};
  JpegErrorTrap trap_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;  // NOLINT(google-runtime-int): libjpeg's type
};

void leave_at_any_warning(j_common_ptr info, int level) {
  if (level < 0) leave_libjpeg(info);
}

class TileDecoder {
 public:
  TileDecoder() {
    info_.err = prepare(&trap_);
    trap_.manager.emit_message = leave_at_any_warning;
  }
  ~TileDecoder() { jpeg_destroy_decompress(&info_); }
  TileDecoder(const TileDecoder&) = delete;
  TileDecoder& operator=(const TileDecoder&) = delete;

  bool decode(TileSize size, std::span<const std::uint8_t> jpeg, std::uint8_t* rgb) {
    if (setjmp(trap_.start) != 0) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, jpeg.data(), jpeg.size());
    jpeg_read_header(&info_, TRUE);
    if (info_.image_width != static_cast<JDIMENSION>(size.rows) ||
        info_.image_height != static_cast<JDIMENSION>(size.columns)) {
      return false;
    }
    info_.out_color_space = JCS_RGB;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      auto* column = rgb + 3 * static_cast<std::size_t>(size.rows) * info_.output_scanline;
      jpeg_read_scanlines(&info_, &column, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }

 private:
  jpeg_decompress_struct info_{};
  JpegErrorTrap trap_{};
};

std::array<std::uint8_t, kCrcBytes> crc_of(std::span<const std::uint8_t> bytes) {
  const auto crc =
      static_cast<std::uint32_t>(::crc32(0, bytes.data(), static_cast<uInt>(bytes.size())));
  std::array<std::uint8_t, kCrcBytes> little_endian{};
  for (std::size_t i = 0; i < kCrcBytes; ++i) {
    little_endian[i] = static_cast<std::uint8_t>(crc >> (8 * i));
  }
  return little_endian;
}

std::vector<std::uint8_t> encode_as_jpeg(TileSize size, const std::uint8_t* rgb, int quality) {
  TileEncoder encoder;
  if (!encoder.encode(size, rgb, quality)) throw std::bad_alloc();  // its only error here
  const std::span<const std::uint8_t> jpeg = encoder.bytes();
  std::vector<std::uint8_t> encoded(kCrcBytes + jpeg.size());
  std::ranges::copy(crc_of(jpeg), encoded.begin());
  std::ranges::copy(jpeg, encoded.begin() + kCrcBytes);
  return encoded;
}

bool decode_jpeg_tile(TileSize size, std::span<const std::uint8_t> encoded, std::uint8_t* rgb) {
  if (encoded.size() < kCrcBytes) return false;
  const std::span<const std::uint8_t> jpeg = encoded.subspan(kCrcBytes);
  return std::ranges::equal(crc_of(jpeg), encoded.first(kCrcBytes)) &&
         TileDecoder().decode(size, jpeg, rgb);
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
