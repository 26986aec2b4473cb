#include "core/files/jpeg_decoder.h"

#include <fmt/format.h>
#include <jerror.h>

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/files/jpeg_errors.h"
#include "core/files/jpeg_scan_check.h"

namespace raywalk {
namespace {

// As many as OpenCV decodes (CV_IO_MAX_IMAGE_PIXELS).
constexpr std::int64_t kMostPixels = std::int64_t{1} << 30;
constexpr int kCmykChannels = 4;

// Warnings have the level -1, explanations for developers 0 and more. A revision of JFIF that
// libjpeg does not know says nothing about the pixels.
void leave_at_warning(j_common_ptr info, int level) {
  if (level < 0 && info->err->msg_code != JWRN_JFIF_MAJOR) leave_libjpeg(info);
}

// One decompression; its functions must be called in this order. They return false on an error or
// warning of libjpeg, which reason() then gives.
class JpegDecoder {
 public:
  JpegDecoder() {
    info_.err = prepare(&trap_);
    trap_.manager.emit_message = leave_at_warning;
  }
  ~JpegDecoder() { jpeg_destroy_decompress(&info_); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  bool read_header(std::span<const std::byte> bytes) {
    if (setjmp(trap_.start) != 0) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info_, TRUE);
    return true;
  }

  std::string damage_of_scan() const { return scan_damage(info_); }

  int width() const { return static_cast<int>(info_.image_width); }
  int height() const { return static_cast<int>(info_.image_height); }
  bool is_cmyk() const { return info_.num_components == kCmykChannels; }

  // Fills `picture`, of the picture's size and with the channels of `space`.
  bool read_pixels(J_COLOR_SPACE space, cv::Mat* picture) {
    if (setjmp(trap_.start) != 0) return false;
    info_.out_color_space = space;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      auto* row = picture->ptr<unsigned char>(static_cast<int>(info_.output_scanline));
      jpeg_read_scanlines(&info_, &row, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }

  // Decodes all data, but computes only one pixel of each block, and writes them to one row of at
  // least width() x 4 bytes.
  bool read_coarse_pixels(unsigned char* row) {
    if (setjmp(trap_.start) != 0) return false;
    info_.scale_num = 1;
    info_.scale_denom = DCTSIZE;
    info_.out_color_space = info_.jpeg_color_space;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) jpeg_read_scanlines(&info_, &row, 1);
    jpeg_finish_decompress(&info_);
    return true;
  }

  std::string reason() const { return trap_.message.data(); }

 private:
  jpeg_decompress_struct info_{};
  JpegErrorTrap trap_{};
};

[[noreturn]] void throw_damaged(const std::string& reason, const std::string& source) {
  throw Error(fmt::format("{}: damaged, cannot be decoded ({}); copy or capture it again", source,
                          one_line(reason)));
}

void read_header(std::span<const std::byte> bytes, const std::string& source,
                 JpegDecoder* decoder) {
  if (!decoder->read_header(bytes)) throw_damaged(decoder->reason(), source);
  if (std::int64_t{decoder->width()} * decoder->height() > kMostPixels) {
    throw Error(fmt::format("{}: {}x{} is too large; cannot be decoded", source, decoder->width(),
                            decoder->height()));
  }
  const std::string damage = decoder->damage_of_scan();
  if (!damage.empty()) throw_damaged(damage, source);
}

// As OpenCV converts CMYK, which JPEG files hold inverted (255 = no ink).
cv::Mat bgr_of_cmyk(const cv::Mat& cmyk) {
  cv::Mat bgr(cmyk.size(), CV_8UC3);
  for (int v = 0; v < cmyk.rows; ++v) {
    for (int u = 0; u < cmyk.cols; ++u) {
      const auto& ink = cmyk.at<cv::Vec4b>(v, u);
      for (int channel = 0; channel < 3; ++channel) {
        bgr.at<cv::Vec3b>(v, u)[2 - channel] =
            static_cast<uchar>(ink[3] - ((255 - ink[channel]) * ink[3] >> 8));
      }
    }
  }
  return bgr;
}

}  // namespace

cv::Mat decode_jpeg(std::span<const std::byte> bytes, JpegColours colours,
                    const std::string& source) {
  JpegDecoder decoder;
  read_header(bytes, source, &decoder);
  const bool grey = colours == JpegColours::kGrey;
  const bool cmyk = decoder.is_cmyk() && !grey;
  const J_COLOR_SPACE space = grey ? JCS_GRAYSCALE : cmyk ? JCS_CMYK : JCS_EXT_BGR;
  cv::Mat picture(decoder.height(), decoder.width(), grey ? CV_8UC1 : cmyk ? CV_8UC4 : CV_8UC3);
  if (!decoder.read_pixels(space, &picture)) throw_damaged(decoder.reason(), source);
  return cmyk ? bgr_of_cmyk(picture) : picture;
}

void require_intact_jpeg(std::span<const std::byte> bytes, const std::string& source) {
  JpegDecoder decoder;
  read_header(bytes, source, &decoder);
  std::vector<unsigned char> row(static_cast<std::size_t>(decoder.width()) * kCmykChannels);
  if (!decoder.read_coarse_pixels(row.data())) throw_damaged(decoder.reason(), source);
}

}  // namespace raywalk
