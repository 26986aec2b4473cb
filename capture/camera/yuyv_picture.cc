#include "capture/camera/yuyv_picture.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// One matrix from (Y, Cb, Cr, 1) in 0..255 to (B, G, R) in 0..255.
//
// Luma is a weighted sum of the primaries, y = kr r + kg g + kb b with kr + kg + kb = 1, and the
// chroma samples are the differences b - y and r - y scaled to -0.5..0.5 (ITU-R BT.601, 2.5.1 and
// 2.5.2): cb = (b - y)/(2 (1 - kb)), cr = (r - y)/(2 (1 - kr)). Solved for the primaries:
//   r = y + 2 (1 - kr) cr
//   b = y + 2 (1 - kb) cb
//   g = (y - kr r - kb b)/kg = y - 2 kr (1 - kr)/kg cr - 2 kb (1 - kb)/kg cb
// In bytes, y = (Y - 16)/219 and c = (C - 128)/224 (BT.601, 2.5.3), or in full range y = Y/255 and
// c = (C - 128)/255 (JFIF).
cv::Matx34d bgr_matrix(const VideoColour& colour) {
  const double kr = colour.kr;
  const double kb = colour.kb;
  const double kg = 1.0 - kr - kb;
  const double luma = 255.0 / (colour.full_range ? 255.0 : 219.0);
  const double black = colour.full_range ? 0.0 : 16.0;
  const double chroma = 255.0 / (colour.full_range ? 255.0 : 224.0);
  const double red = 2.0 * (1.0 - kr) * chroma;
  const double blue = 2.0 * (1.0 - kb) * chroma;
  const auto row = [&](double cb, double cr) {
    return cv::Vec4d(luma, cb, cr, -luma * black - 128.0 * (cb + cr));
  };
  const cv::Vec4d b = row(blue, 0.0);
  const cv::Vec4d g = row(-blue * kb / kg, -red * kr / kg);
  const cv::Vec4d r = row(0.0, red);
  return {b[0], b[1], b[2], b[3], g[0], g[1], g[2], g[3], r[0], r[1], r[2], r[3]};
}

// Every pixel with its Y, Cb and Cr.
cv::Mat unpacked(std::span<const std::byte> frame, const VideoFormat& format) {
  cv::Mat pixels(format.size.height, format.size.width, CV_8UC3);
  for (int v = 0; v < pixels.rows; ++v) {
    const std::byte* pair = frame.data() + static_cast<std::size_t>(v) * format.bytes_per_line;
    auto* out = pixels.ptr<unsigned char>(v);
    for (int u = 0; u + 1 < pixels.cols; u += 2, pair += 4, out += 6) {
      const auto cb = static_cast<unsigned char>(pair[1]);
      const auto cr = static_cast<unsigned char>(pair[3]);
      out[0] = static_cast<unsigned char>(pair[0]);
      out[1] = cb;
      out[2] = cr;
      out[3] = static_cast<unsigned char>(pair[2]);
      out[4] = cb;
      out[5] = cr;
    }
  }
  return pixels;
}

}  // namespace

std::size_t min_yuyv_bytes(const VideoFormat& format) {
  if (format.size.width <= 0 || format.size.height <= 0) return 0;
  return static_cast<std::size_t>(format.size.height - 1) * format.bytes_per_line +
         2 * static_cast<std::size_t>(format.size.width);
}

cv::Mat bgr_from_yuyv(std::span<const std::byte> frame, const VideoFormat& format) {
  cv::Mat bgr;
  cv::transform(unpacked(frame, format), bgr, bgr_matrix(format.colour));
  return bgr;
}

std::string jpeg_from_yuyv(std::span<const std::byte> frame, const VideoFormat& format,
                           int quality) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", bgr_from_yuyv(frame, format), bytes,
                    {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw Error("cannot encode a camera's frame as JPEG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace raywalk::capture
