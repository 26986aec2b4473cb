#include "capture/camera/v4l2_camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <utility>
#include <vector>

#include "capture/base/device_fault.h"
#include "capture/base/word_of.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/image_file.h"

namespace raywalk::capture {
namespace {

// The driver can fill one while another is read.
constexpr int kBuffers = 4;
// Longest delay of the reaction to an interrupt.
constexpr Duration kStep = std::chrono::milliseconds(50);
// For automatic exposure, gain and white balance to settle: webcams take up to about a second.
constexpr Duration kMeasuring = std::chrono::milliseconds(1500);
// A sensor uses a new exposure time one to three frames after it was told.
constexpr int kFramesUntilExposed = 3;

std::string text_of(PanoramaSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

// The damage of a frame that the driver did not flag; empty if none.
std::string mjpg_damage(std::span<const std::byte> frame, PanoramaSize size) {
  if (frame.empty()) return "empty";
  try {
    const ImageHeader header = require_intact_image(frame, std::to_string(frame.size()) + " bytes");
    return header.size == size ? "" : "of " + text_of(header.size);
  } catch (const Error& error) {
    return error.what();
  }
}

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

// Every pixel of V4L2_PIX_FMT_YUYV, two pixels in four bytes (Y0 Cb Y1 Cr), with its Y, Cb and Cr.
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

// The minimum size of a frame of the format in bytes: the last line may lack its padding.
std::size_t min_yuyv_bytes(const VideoFormat& format) {
  return static_cast<std::size_t>(format.size.height - 1) * format.bytes_per_line +
         2 * static_cast<std::size_t>(format.size.width);
}

// The bytes of a JPEG file. Pixel pairs already share a chroma sample, so JPEG's chroma subsampling
// loses resolution only between lines.
std::string jpeg_from_yuyv(std::span<const std::byte> frame, const VideoFormat& format,
                           int quality) {
  cv::Mat bgr;
  cv::transform(unpacked(frame, format), bgr, bgr_matrix(format.colour));
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw Error("cannot encode a camera's frame as JPEG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace

V4l2Camera::V4l2Camera(const CameraConfig& config, std::unique_ptr<VideoDevice> device,
                       Clock* clock)
    : config_(config),
      pixels_(word_of(config.v4l2.pixel_format, {"MJPG", "YUYV"})),
      device_(std::move(device)),
      clock_(clock),
      exposure_(device_.get()) {}

std::string V4l2Camera::description() const {
  return device_->identity().card + " at " + device_->path();
}

CameraReport V4l2Camera::report() {
  const PanoramaSize asked = asked_size();
  const VideoFormat format = expected(device_->try_format(pixels_, asked), asked);
  const VideoIdentity identity = device_->identity();
  CameraReport report;
  report.identity = identity.card + ", driver " + identity.driver + ", bus " + identity.bus;
  report.state =
      (format_ ? "streams " : "can stream ") + text_of(format.size) + " " + format.pixels;
  return report;
}

std::string V4l2Camera::prepare(const ExposureSettings& exposure, const std::string& earlier) {
  bracket_ev_ = exposure.bracket_ev.empty() ? std::vector<double>{0.0} : exposure.bracket_ev;
  start();
  std::string locked = exposure_.lock(exposure, earlier, [this] { let_camera_measure(); });
  // Waits until the new exposure is in effect, and checks that a complete frame arrives.
  take(clock_->now(), locked.empty() ? 0 : kFramesUntilExposed);
  return locked;
}

Shot V4l2Camera::shoot(SteadyTime settled_at) {
  start();
  const SteadyTime triggered = clock_->now();
  const bool is_bracket = is_bracketed(bracket_ev_);
  Shot shot;
  shot.triggered_at = wall_time_of(*clock_, triggered);
  for (const double ev : bracket_ev_) {
    SteadyTime begin = settled_at;
    if (is_bracket) {
      exposure_.bracket(ev);
      begin = std::max(begin, clock_->now());
    }
    const Duration exposing =
        std::max(duration_from_ms(config_.v4l2.exposure_ms), exposure_.locked_time());
    Taken taken = take(begin + exposing, is_bracket ? kFramesUntilExposed : 0);
    if (shot.pictures.empty()) shot.exposed_at = wall_time_of(*clock_, taken.stamped_at);
    shot.pictures.push_back(std::move(taken.picture));
  }
  shot.exposing_ms = ms_from_duration(clock_->now() - triggered);
  return shot;
}

PanoramaSize V4l2Camera::asked_size() {
  if (format_) return format_->size;
  if (config_.width_px > 0 && config_.height_px > 0) return {config_.width_px, config_.height_px};
  return device_->current_size();
}

// A driver does not refuse a format but offers its nearest one.
VideoFormat V4l2Camera::expected(const VideoFormat& offered, PanoramaSize asked) const {
  if (offered.pixels != pixels_ || offered.size != asked) {
    throw fault(FaultKind::kWrongDevice,
                "offers " + text_of(offered.size) + " " + offered.pixels + " instead of " +
                    text_of(asked) + " " + pixels_ +
                    "; set camera.width_px, height_px and v4l2.pixel_format to what "
                    "v4l2-ctl --list-formats-ext lists");
  }
  if (config_.frames == FrameKind::kPanorama && asked.width != 2 * asked.height) {
    throw fault(FaultKind::kWrongDevice,
                "gives " + text_of(asked) +
                    ", and a panorama is twice as wide as high; set camera.width_px and height_px "
                    "so, or camera.frames to dual-fisheye");
  }
  if (pixels_ == "YUYV" && asked.width % 2 != 0) {
    throw fault(FaultKind::kWrongDevice, "gives an odd width, " + text_of(asked) +
                                             ", which YUYV does not allow; choose another size");
  }
  return offered;
}

void V4l2Camera::start() {
  if (format_) return;
  const PanoramaSize asked = asked_size();
  const VideoFormat format = expected(device_->set_format(pixels_, asked), asked);
  device_->start(kBuffers);
  format_ = format;
}

void V4l2Camera::let_camera_measure() {
  const SteadyTime end = clock_->now() + kMeasuring;
  while (clock_->now() < end) {
    throw_if_interrupted();
    device_->next_frame(std::min(kStep, end - clock_->now()));
  }
}

V4l2Camera::Taken V4l2Camera::take(SteadyTime not_before, int passed_over) {
  const Duration patience = duration_from_ms(config_.v4l2.frame_timeout_ms);
  SteadyTime deadline = std::max(clock_->now(), not_before) + patience;
  int stale = 0;
  int damaged = 0;
  std::string damage;
  while (clock_->now() < deadline) {
    throw_if_interrupted();
    const std::optional<VideoFrame> frame =
        device_->next_frame(std::min(kStep, deadline - clock_->now()));
    if (!frame) continue;
    if (!frame->stamped_at) {
      throw fault(
          FaultKind::kWrongDevice,
          "does not stamp frames by the monotonic clock, so old and new frames cannot be "
          "distinguished; load its driver with that clock (uvcvideo: clock=CLOCK_MONOTONIC)");
    }
    if (*frame->stamped_at < not_before) {
      ++stale;
    } else if (passed_over > 0) {
      --passed_over;
      deadline = clock_->now() + patience;
    } else if (std::optional<Picture> picture = picture_of(*frame, &damage)) {
      picture->exposure = exposure_.confirm();
      return {std::move(*picture), *frame->stamped_at};
    } else {
      ++damaged;
    }
  }
  const std::string within =
      " within " + std::to_string(std::lround(config_.v4l2.frame_timeout_ms)) + " ms";
  if (damaged > 0) {
    throw fault(FaultKind::kBadPicture, "gave only damaged frames" + within + " (" +
                                            std::to_string(damaged) + ", the last one " + damage +
                                            "); check its cable, and try another port or a "
                                            "smaller size");
  }
  throw fault(FaultKind::kTimeout,
              "gave no frame" + within + " of settling (" + std::to_string(stale) +
                  " older ones); plug it in again, or raise camera.v4l2.frame_timeout_ms");
}

std::optional<Picture> V4l2Camera::picture_of(const VideoFrame& frame, std::string* damage) const {
  *damage = "marked by the driver";
  if (frame.is_damaged) return std::nullopt;
  Picture picture;
  picture.extension = "jpg";
  picture.size = format_->size;
  if (pixels_ == "YUYV") {
    *damage = "of " + std::to_string(frame.bytes.size()) + " bytes";
    if (frame.bytes.size() < min_yuyv_bytes(*format_)) return std::nullopt;
    picture.bytes = jpeg_from_yuyv(frame.bytes, *format_, config_.v4l2.jpeg_quality);
    return picture;
  }
  *damage = mjpg_damage(frame.bytes, format_->size);
  if (!damage->empty()) return std::nullopt;
  // Without Huffman tables, which motion-JPEG may omit, decoders take the standard ones.
  picture.bytes.assign(reinterpret_cast<const char*>(frame.bytes.data()), frame.bytes.size());
  return picture;
}

DeviceFault V4l2Camera::fault(FaultKind kind, const std::string& what) const {
  return {kind, "camera " + device_->path() + " " + what};
}

}  // namespace raywalk::capture
