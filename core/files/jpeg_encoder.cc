#include "core/files/jpeg_encoder.h"

#include <fmt/format.h>

#include <cstdlib>

#include "core/base/error.h"
#include "core/files/jpeg_errors.h"

namespace raywalk {
namespace {

// One compression into memory of its own.
class JpegEncoder {
 public:
  JpegEncoder() { info_.err = prepare(&trap_); }
  ~JpegEncoder() {
    jpeg_destroy_compress(&info_);
    std::free(bytes_);
  }
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  // False on an error of libjpeg, which reason() then gives.
  bool encode(const cv::Mat& picture, int quality) {
    if (setjmp(trap_.start) != 0) return false;
    jpeg_create_compress(&info_);
    jpeg_mem_dest(&info_, &bytes_, &size_);
    info_.image_width = static_cast<JDIMENSION>(picture.cols);
    info_.image_height = static_cast<JDIMENSION>(picture.rows);
    info_.input_components = picture.channels();
    info_.in_color_space = JCS_EXT_BGR;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    info_.optimize_coding = TRUE;
    for (int i = 0; i < info_.num_components; ++i) {
      info_.comp_info[i].h_samp_factor = info_.comp_info[i].v_samp_factor = 1;
    }
    jpeg_start_compress(&info_, TRUE);
    while (info_.next_scanline < info_.image_height) {
      // libjpeg does not write to it.
      auto* row = const_cast<unsigned char*>(picture.ptr(static_cast<int>(info_.next_scanline)));
      jpeg_write_scanlines(&info_, &row, 1);
    }
    jpeg_finish_compress(&info_);
    return true;
  }

  std::vector<std::byte> bytes() const {
    const auto* first = reinterpret_cast<const std::byte*>(bytes_);
    return {first, first + size_};
  }
  std::string reason() const { return trap_.message.data(); }

 private:
  jpeg_compress_struct info_{};
  JpegErrorTrap trap_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;  // NOLINT(google-runtime-int): libjpeg's type
};

}  // namespace

std::vector<std::byte> encode_jpeg(const cv::Mat& picture, int quality) {
  if (picture.empty() || picture.type() != CV_8UC3) {
    throw Error(fmt::format("a {}x{} picture of OpenCV type {} cannot be written as JPEG",
                            picture.cols, picture.rows, cv::typeToString(picture.type())));
  }
  JpegEncoder encoder;
  if (!encoder.encode(picture, quality)) {
    throw Error(fmt::format("a {}x{} picture cannot be written as JPEG ({})", picture.cols,
                            picture.rows, one_line(encoder.reason())));
  }
  return encoder.bytes();
}

}  // namespace raywalk
