#include "capture/run/check_devices.h"

#include <fmt/format.h>

#include <functional>
#include <stdexcept>

#include "capture/base/units.h"
#include "capture/camera/gpio_camera.h"
#include "capture/camera/osc_camera.h"
#include "capture/camera/v4l2_camera.h"
#include "capture/camera/video_device.h"
#include "capture/plan/line_selection.h"
#include "capture/plan/plan_report.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr double kBytesOfGigabyte = 1e9;
constexpr double kGigabytesOfMegabyte = 1e-3;

void append_flag(std::string* text, std::optional<bool> flag, const char* yes, const char* no) {
  if (flag) *text += std::string(", ") + (*flag ? yes : no);
}

std::string state_text(const SliderState& state) {
  std::string text = fmt::format("at {:.3f} mm", state.position_mm);
  append_flag(&text, state.homed, "homed", "not homed yet");
  append_flag(&text, state.enabled, "enabled", "disabled");
  append_flag(&text, state.moving, "moving", "at rest");
  if (state.at_low_limit.value_or(false)) text += ", on its low limit switch";
  if (state.at_high_limit.value_or(false)) text += ", on its high limit switch";
  if (!state.alarm) text += ", no alarm";
  return text;
}

std::string check_slider(const CaptureConfig& config, Clock* clock) {
  const auto slider = open_slider(config.slider, clock);
  const SliderState state = slider->read_state();
  if (state.alarm) {
    throw Error(
        fmt::format("{}: alarm {}; see the drive's manual, clear its cause and run "
                    "raywalk-capture home",
                    slider->description(), state.alarm_code));
  }
  return slider->description() + ": " + state_text(state);
}

std::string report_text(const CameraReport& report) {
  std::string text = report.identity + ": " + report.state;
  if (report.free_bytes) {
    text +=
        fmt::format(", {:.2f} GB free", static_cast<double>(*report.free_bytes) / kBytesOfGigabyte);
  }
  if (report.pictures_left) text += fmt::format(", room for {} pictures", *report.pictures_left);
  if (report.battery_share) text += fmt::format(", battery {:.0f} %", *report.battery_share * 100);
  return text;
}

std::string check_camera(const CaptureConfig& config, std::size_t pictures, Clock* clock) {
  const auto camera = open_camera(config.camera, clock);
  const CameraReport report = camera->report();
  require_room_on_card(report, pictures);
  return report_text(report);
}

double free_mb(const std::filesystem::path& directory) {
  return static_cast<double>(std::filesystem::space(directory).available) / kBytesPerMegabyte;
}

std::string check_disk(const CaptureConfig& config, std::size_t pictures,
                       const std::filesystem::path& disk) {
  require_room_on_disk(disk, pictures, config);
  return fmt::format("{}: {:.2f} GB free, enough for {} pictures", disk.string(),
                     free_mb(disk) * kGigabytesOfMegabyte, pictures);
}

DeviceCheck check(const std::string& device, const std::function<std::string()>& ask) {
  try {
    return {device, true, ask()};
  } catch (const std::exception& error) {
    return {device, false, error.what()};
  }
}

}  // namespace

std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock) {
  switch (config.kind) {
    case CameraKind::kOsc:
      return std::make_unique<OscCamera>(config, *clock);
    case CameraKind::kV4l2:
      return std::make_unique<V4l2Camera>(config, open_video_device(config.v4l2.device), clock);
    case CameraKind::kGpio:
      return std::make_unique<GpioCamera>(config.trigger, open_gpio_chip(config.trigger.chip),
                                          clock);
  }
  throw std::logic_error("unknown kind of camera");
}

SoftLimits limits_of(const SliderConfig& config) {
  return SoftLimits(config.low_limit_mm, config.high_limit_mm);
}

std::vector<DeviceCheck> check_devices(const CaptureConfig& config,
                                       const std::filesystem::path& disk,
                                       const std::vector<std::string>& lines) {
  SystemClock clock;
  const CapturePlan plan = select_lines(plan_capture(config), config.camera, lines);
  const std::size_t pictures = plan.stations() * config.camera.exposure.bracket_ev.size();
  return {check("slider", [&] { return check_slider(config, &clock); }),
          check("camera", [&] { return check_camera(config, pictures, &clock); }),
          check("disk", [&] { return check_disk(config, pictures, disk); })};
}

void require_room_on_card(const CameraReport& report, std::size_t pictures) {
  if (report.pictures_left && static_cast<std::size_t>(*report.pictures_left) < pictures) {
    throw Error(
        fmt::format("{}: the camera has room for {} pictures, {} are still to be taken; "
                    "empty its card",
                    report.identity, *report.pictures_left, pictures));
  }
}

void require_room_on_disk(const std::filesystem::path& directory, std::size_t pictures,
                          const CaptureConfig& config) {
  const double needed_mb =
      static_cast<double>(pictures) * picture_mb(config).value_or(0.0) + config.run.least_free_mb;
  if (free_mb(directory) >= needed_mb) return;
  throw Error(
      fmt::format("{}: {:.0f} MB are free on its disk, {} pictures and "
                  "run.least_free_mb take about {:.0f} MB; free some or use another disk",
                  directory.string(), free_mb(directory), pictures, needed_mb));
}

}  // namespace raywalk::capture
