#include "capture/camera/fake_video_device.h"

#include <linux/v4l2-controls.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

bool is_due(int every, int number) { return every > 0 && number % every == 0; }
bool is_over(int after, int number) { return after > 0 && number >= after; }

cv::Mat grey_scene(SteadyTime /*exposed*/, int exposure_100us, PanoramaSize size) {
  return {size.height, size.width, CV_8UC3, cv::Scalar::all(std::min(exposure_100us / 4, 255))};
}

// The file without its segments of Huffman tables (T.81 B.1.1.4), as motion-JPEG cameras send it.
std::string without_huffman_tables(const std::string& file) {
  std::string frame = file.substr(0, 2);
  std::size_t offset = 2;
  while (static_cast<unsigned char>(file[offset + 1]) != 0xDA) {
    const std::size_t length = 2 + std::size_t{256} * static_cast<unsigned char>(file[offset + 2]) +
                               static_cast<unsigned char>(file[offset + 3]);
    if (static_cast<unsigned char>(file[offset + 1]) != 0xC4) frame += file.substr(offset, length);
    offset += length;
  }
  return frame + file.substr(offset);
}

// As ITU-R BT.601 has it, in limited range.
cv::Mat ycbcr_from_bgr(const cv::Mat& bgr) {
  cv::Mat ycrcb;
  cv::cvtColor(bgr, ycrcb, cv::COLOR_BGR2YCrCb);  // full range
  std::vector<cv::Mat> planes;
  cv::split(ycrcb, planes);
  planes[0].convertTo(planes[0], -1, 219.0 / 255.0, 16.0);
  for (const int c : {1, 2})
    planes[c].convertTo(planes[c], -1, 224.0 / 255.0, 128.0 - 128.0 * 224.0 / 255.0);
  cv::merge(planes, ycrcb);
  return ycrcb;
}

std::string yuyv_from_bgr(const cv::Mat& bgr, const VideoFormat& format) {
  const cv::Mat ycrcb = ycbcr_from_bgr(bgr);
  std::string bytes;
  for (int v = 0; v < ycrcb.rows; ++v) {
    const std::size_t line_end = bytes.size() + format.bytes_per_line;
    for (int u = 0; u + 1 < ycrcb.cols; u += 2) {
      const auto& left = ycrcb.at<cv::Vec3b>(v, u);
      const auto& right = ycrcb.at<cv::Vec3b>(v, u + 1);
      for (const int sample :
           {int{left[0]}, (left[2] + right[2]) / 2, int{right[0]}, (left[1] + right[1]) / 2}) {
        bytes += static_cast<char>(sample);
      }
    }
    bytes.resize(line_end, '\0');
  }
  return bytes;
}

}  // namespace

FakeVideoDevice::FakeVideoDevice(FakeVideoSettings settings, Clock* clock, FakeScene scene)
    : settings_(std::move(settings)),
      clock_(clock),
      scene_(scene ? std::move(scene) : grey_scene),
      controls_{{VideoControl::kExposureMode, V4L2_EXPOSURE_APERTURE_PRIORITY},
                {VideoControl::kExposure, 156},
                {VideoControl::kAutoGain, 1},
                {VideoControl::kGain, 8},
                {VideoControl::kAutoWhiteBalance, 1},
                {VideoControl::kWhiteBalance, 4600}},
      period_(duration_from_ms(1000.0 / settings_.frames_per_second)) {
  format_ = try_format("MJPG", {settings_.width_px, settings_.height_px});
}

VideoIdentity FakeVideoDevice::identity() const {
  return {.driver = "fake 1.0.0", .card = "Fake 360", .bus = "usb-fake"};
}

PanoramaSize FakeVideoDevice::current_size() { return format_.size; }

VideoFormat FakeVideoDevice::try_format(const std::string& pixels, PanoramaSize size) {
  VideoFormat format;
  format.pixels = settings_.pixels.empty() ? pixels : settings_.pixels;
  format.size = settings_.any_size ? size : PanoramaSize{settings_.width_px, settings_.height_px};
  format.bytes_per_line = 2 * static_cast<std::size_t>(format.size.width) +
                          static_cast<std::size_t>(settings_.line_padding_bytes);
  return format;
}

VideoFormat FakeVideoDevice::set_format(const std::string& pixels, PanoramaSize size) {
  if (settings_.taken) {
    throw DeviceFault(FaultKind::kBusy,
                      "camera " + path() + " is in use by another program; end that");
  }
  format_ = try_format(pixels, size);
  return format_;
}

std::optional<ControlRange> FakeVideoDevice::range_of(VideoControl control) {
  if (!settings_.controls) return std::nullopt;
  switch (control) {
    case VideoControl::kExposureMode:
      return ControlRange{0, 3, 1};
    case VideoControl::kExposure:
      return ControlRange{1, 5000, 1};
    case VideoControl::kGain:
      return ControlRange{0, 100, 1};
    case VideoControl::kWhiteBalance:
      return ControlRange{2800, 6500, 10};
    default:
      return ControlRange{0, 1, 1};
  }
}

int FakeVideoDevice::control(VideoControl control) {
  const bool measures = controls_.at(VideoControl::kExposureMode) != V4L2_EXPOSURE_MANUAL;
  if (control == VideoControl::kExposure && measures) return settings_.sensor_exposure;
  return controls_.at(control);
}

bool FakeVideoDevice::set_control(VideoControl control, int value) {
  const std::optional<ControlRange> range = range_of(control);
  // As a fixed aperture has it: priority of the aperture is the only automatic.
  const bool is_unknown_mode =
      control == VideoControl::kExposureMode && value == V4L2_EXPOSURE_AUTO;
  if (!range || is_unknown_mode || settings_.refused_control == name_of(control)) return false;
  if (value < range->least || value > range->most) return false;
  expose_until_now();
  const int before = exposure_now();
  controls_[control] = value / range->step * range->step;
  if (exposure_now() != before) {
    exposures_.assign(static_cast<std::size_t>(settings_.exposure_delay_frames), before);
  }
  return true;
}

int FakeVideoDevice::exposure_now() const {
  return controls_.at(VideoControl::kExposureMode) == V4L2_EXPOSURE_MANUAL
             ? controls_.at(VideoControl::kExposure)
             : settings_.sensor_exposure;
}

void FakeVideoDevice::start(int buffers) {
  free_buffers_ = buffers;
  next_exposed_ = clock_->now() + period_;
}

std::optional<VideoFrame> FakeVideoDevice::next_frame(Duration timeout) {
  expose_until_now();
  if (std::exchange(lends_, false)) ++free_buffers_;
  const bool is_silent = is_over(settings_.silent_after_frame, frames_);
  if (queued_.empty()) {
    const Duration wait = std::min(timeout, next_exposed_ - clock_->now());
    clock_->sleep(is_silent ? timeout : wait);
    expose_until_now();
  }
  if (is_over(settings_.gone_after_frame, frames_) && queued_.empty()) {
    throw DeviceFault(FaultKind::kNoContact,
                      "camera " + path() + " was unplugged; plug it in again and resume");
  }
  if (queued_.empty()) return std::nullopt;
  const Exposed exposed = queued_.front();
  queued_.pop_front();
  lends_ = true;
  return frame_of(exposed);
}

// Without a free buffer a frame is lost, as with a real driver.
void FakeVideoDevice::expose_until_now() {
  for (; next_exposed_ <= clock_->now(); next_exposed_ += period_) {
    const bool has_ended = is_over(settings_.silent_after_frame, frames_) ||
                           is_over(settings_.gone_after_frame, frames_);
    if (free_buffers_ == 0 || has_ended) {
      // Where nothing can change until someone takes a frame, time may pass at once.
      next_exposed_ += (clock_->now() - next_exposed_) / period_ * period_;
      continue;
    }
    int exposure = exposure_now();
    if (!exposures_.empty()) {
      exposure = exposures_.front();
      exposures_.pop_front();
    }
    --free_buffers_;
    queued_.push_back({next_exposed_, ++frames_, exposure});
    if (settings_.drift_after_frame == frames_) controls_[VideoControl::kExposure] += 40;
  }
}

VideoFrame FakeVideoDevice::frame_of(const Exposed& exposed) {
  bytes_ = encoded(scene_(exposed.at, exposed.exposure_100us, format_.size));
  if (is_due(settings_.short_every, exposed.number)) bytes_.resize(bytes_.size() / 2);
  if (is_due(settings_.empty_every, exposed.number)) bytes_.clear();
  VideoFrame frame;
  frame.bytes = std::as_bytes(std::span(bytes_));
  frame.is_damaged = is_due(settings_.damaged_every, exposed.number);
  if (settings_.monotonic_stamps) frame.stamped_at = exposed.at;
  return frame;
}

std::string FakeVideoDevice::encoded(const cv::Mat& picture) const {
  if (format_.pixels == "YUYV") return yuyv_from_bgr(picture, format_);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  return without_huffman_tables({bytes.begin(), bytes.end()});
}

}  // namespace raywalk::capture
