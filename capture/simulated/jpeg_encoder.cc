#include "capture/simulated/jpeg_encoder.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/files/jpeg_errors.h"

namespace raywalk::capture {
namespace {

// A growing stream in memory. (libjpeg's jpeg_mem_dest leaves a dangling pointer behind when memory
// runs out.)
class MemoryStream {
 public:
  MemoryStream() : file_(open_memstream(&bytes_, &size_)) {
    if (file_ == nullptr) throw Error("cannot encode JPEG: out of memory");
  }
  ~MemoryStream() {
    std::fclose(file_);
    std::free(bytes_);
  }
  MemoryStream(const MemoryStream&) = delete;
  MemoryStream& operator=(const MemoryStream&) = delete;

  std::FILE* file() const { return file_; }
  // What was written until the last flush (open_memstream(3)).
  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_, size_)); }

 private:
  char* bytes_ = nullptr;
  std::size_t size_ = 0;
  std::FILE* file_;
};

void set_up(jpeg_compress_struct* encoder, const cv::Mat& image, int quality, JpegColour colour,
            std::FILE* out) {
  jpeg_create_compress(encoder);
  jpeg_stdio_dest(encoder, out);
  encoder->image_width = static_cast<JDIMENSION>(image.cols);
  encoder->image_height = static_cast<JDIMENSION>(image.rows);
  encoder->input_components = 3;
  encoder->in_color_space = JCS_EXT_BGR;  // of libjpeg-turbo
  jpeg_set_defaults(encoder);
  jpeg_set_quality(encoder, quality, TRUE);
  const int luma_per_chroma = colour == JpegColour::kFull ? 1 : 2;
  encoder->comp_info[0].h_samp_factor = luma_per_chroma;
  encoder->comp_info[0].v_samp_factor = luma_per_chroma;
}

// Returns whether encoding succeeded; all output is then flushed. No object here may have a
// destructor, as longjmp would skip it.
bool run_encoder(const cv::Mat& image, int quality, JpegColour colour, JpegErrorTrap* trap,
                 std::FILE* out) {
  jpeg_compress_struct encoder{};
  encoder.err = prepare(trap);
  if (setjmp(trap->start) != 0) {
    jpeg_destroy_compress(&encoder);
    return false;
  }
  set_up(&encoder, image, quality, colour, out);
  jpeg_start_compress(&encoder, TRUE);
  while (encoder.next_scanline < encoder.image_height) {
    // libjpeg does not write to the rows.
    auto* row = const_cast<unsigned char*>(
        image.ptr<unsigned char>(static_cast<int>(encoder.next_scanline)));
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  return true;
}

}  // namespace

std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality, JpegColour colour) {
  if (image.type() != CV_8UC3) throw Error("a JPEG picture must have three 8-bit channels");
  JpegErrorTrap trap{};
  const MemoryStream stream;
  if (!run_encoder(image, quality, colour, &trap, stream.file())) {
    throw Error("cannot encode JPEG: " + std::string(trap.message.data()));
  }
  return {stream.bytes().begin(), stream.bytes().end()};
}

}  // namespace raywalk::capture
