#include "core/files/jpeg.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <cstdint>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"

namespace raywalk {
namespace {

using Bytes = std::span<const std::byte>;

// As many as OpenCV decodes (CV_IO_MAX_IMAGE_PIXELS).
constexpr std::int64_t kMostPixels = std::int64_t{1} << 30;
constexpr tjscalingfactor kCoarse = {1, 8};  // one pixel of each block

struct HandleCloser {
  void operator()(tjhandle handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<std::remove_pointer_t<tjhandle>, HandleCloser>;

Handle handle_of(tjhandle made) {
  if (made == nullptr) throw std::bad_alloc();
  return Handle(made);
}

const unsigned char* first_of(Bytes bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

// Warnings of libjpeg that say nothing about the pixels.
bool is_harmless(std::string_view warning) {
  return warning.find("extraneous bytes before marker") != std::string_view::npos ||
         warning.find("unknown JFIF revision") != std::string_view::npos;
}

// Whether an end marker follows the last scan: within a scan's data there is none (ITU-T T.81,
// F.1.2.3). TurboJPEG tells the first of several warnings only, so that after a harmless one it
// does not say that data are missing.
bool has_end(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t scan = text.rfind("\xFF\xDA");
  return scan != std::string_view::npos && text.find("\xFF\xD9", scan) != std::string_view::npos;
}

// Fills `image`, of the file's size or that of kCoarse.
void decode_into(Bytes bytes, TJPF format, const std::string& source, cv::Mat* image) {
  const Handle handle = handle_of(tjInitDecompress());
  const int failed =
      tjDecompress2(handle.get(), first_of(bytes), bytes.size(), image->data, image->cols,
                    static_cast<int>(image->step), image->rows, format, TJFLAG_LIMITSCANS);
  if (failed == 0) return;
  const std::string reason = tjGetErrorStr2(handle.get());
  const bool warned = tjGetErrorCode(handle.get()) == TJERR_WARNING;
  if (!warned || !is_harmless(reason) || !has_end(bytes)) throw_damaged_image(source, reason);
}

JpegHeader header_to_decode(Bytes bytes, const std::string& source) {
  const JpegHeader header = read_jpeg_header(bytes, source);
  if (std::int64_t{header.width} * header.height > kMostPixels) {
    throw Error(fmt::format("{}: {}x{} is too large; cannot be decoded", source, header.width,
                            header.height));
  }
  return header;
}

}  // namespace

JpegHeader read_jpeg_header(Bytes bytes, const std::string& source) {
  const Handle handle = handle_of(tjInitDecompress());
  JpegHeader header;
  int sampling = 0, space = 0;
  // Fails also where it does not know how the colours are sampled; the size is known by then.
  tjDecompressHeader3(handle.get(), first_of(bytes), bytes.size(), &header.width, &header.height,
                      &sampling, &space);
  if (header.width < 1 || header.height < 1) {
    throw_damaged_image(source, tjGetErrorStr2(handle.get()));
  }
  header.is_grey = space == TJCS_GRAY;
  return header;
}

cv::Mat decode_jpeg(Bytes bytes, int type, const std::string& source) {
  const JpegHeader header = header_to_decode(bytes, source);
  cv::Mat image(header.height, header.width, type);
  decode_into(bytes, type == CV_8UC1 ? TJPF_GRAY : TJPF_BGR, source, &image);
  return image;
}

void require_intact_jpeg(Bytes bytes, const std::string& source) {
  const JpegHeader header = header_to_decode(bytes, source);
  cv::Mat image(TJSCALED(header.height, kCoarse), TJSCALED(header.width, kCoarse), CV_8UC1);
  decode_into(bytes, TJPF_GRAY, source, &image);
}

void throw_damaged_image(const std::string& source, const std::string& reason) {
  throw Error(fmt::format("{}: the image is damaged or cut short ({}); capture or copy it again",
                          source, one_line(reason)));
}

std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality, JpegSampling sampling) {
  if (image.empty() || image.type() != CV_8UC3) {
    throw Error(fmt::format("a {}x{} image of OpenCV type {} cannot be written as JPEG", image.cols,
                            image.rows, cv::typeToString(image.type())));
  }
  const Handle handle = handle_of(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  const int failed = tjCompress2(handle.get(), image.data, image.cols, static_cast<int>(image.step),
                                 image.rows, TJPF_BGR, &bytes, &size,
                                 sampling == JpegSampling::kFull ? TJSAMP_444 : TJSAMP_420, quality,
                                 TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(bytes, tjFree);
  if (failed != 0) {
    throw Error(fmt::format("a {}x{} image cannot be written as JPEG ({})", image.cols, image.rows,
                            one_line(tjGetErrorStr2(handle.get()))));
  }
  const auto* first = reinterpret_cast<const std::byte*>(bytes);
  return {first, first + size};
}

}  // namespace raywalk
