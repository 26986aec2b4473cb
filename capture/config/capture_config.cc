#include "capture/config/capture_config.h"

#include <spdlog/fmt/fmt.h>

#include <set>
#include <system_error>

#include "capture/base/http_url.h"
#include "capture/config/capture_schema.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/shipped_configs.h"

namespace raywalk::capture {
namespace {

void require_grid(const CaptureConfig& config) {
  const double overhang_mm = config.grid.overhang_mm;
  if (overhang_mm < 0.0 && overhang_mm != -1.0) {
    refuse_setting(
        config, "grid.overhang_mm",
        fmt::format("is {}; it must be 0 or more, or -1 for as much as k_deg needs", overhang_mm));
  }
}

void require_validation(const CaptureConfig& config) {
  for (std::size_t i = 0; i < config.validation.size(); ++i) {
    const ValidationLine& line = config.validation[i];
    if (line.from_m < line.to_m) continue;
    refuse_setting(
        config, fmt::format("validation[{}].to_m", i),
        fmt::format("is {}; it must be larger than from_m, which is {}", line.to_m, line.from_m));
  }
}

void require_scene(const CaptureConfig& config) {
  const CaptureScene& scene = config.scene;
  if (scene.farthest_m > 0.0 && scene.farthest_m < scene.nearest_m) {
    refuse_setting(config, "scene.farthest_m",
                   fmt::format("is {}; it must not be below nearest_m, which is {}",
                               scene.farthest_m, scene.nearest_m));
  }
}

void require_connection(const CaptureConfig& config) {
  const auto impossible = impossible_connection(config.slider);
  if (impossible) refuse_setting(config, impossible->key, impossible->what);
}

void require_register_map(const CaptureConfig& config) {
  const std::filesystem::path& map = config.slider.register_map;
  if (map.empty()) {
    refuse_setting(config, "slider.register_map",
                   "is missing; name the map of the drive's registers, for example "
                   "leadshine-pr0");
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(map, error)) {
    refuse_setting(config, "slider.register_map", missing_config_text(map, ConfigKind::kSlider));
  }
}

void require_limits(const CaptureConfig& config) {
  const SliderConfig& slider = config.slider;
  if (!(slider.low_limit_mm < slider.high_limit_mm)) {
    refuse_setting(config, "slider.high_limit_mm",
                   fmt::format("is {}; it must be above low_limit_mm, which is {}",
                               slider.high_limit_mm, slider.low_limit_mm));
  }
  const MotionRules& motion = slider.motion;
  if (motion.following_error_mm < motion.settle_tolerance_mm) {
    refuse_setting(config, "slider.motion.following_error_mm",
                   fmt::format("is {}; it must not be below settle_tolerance_mm, which is {}",
                               motion.following_error_mm, motion.settle_tolerance_mm));
  }
  if (motion.poll_ms > motion.stall_ms) {
    refuse_setting(config, "slider.motion.poll_ms",
                   fmt::format("is {}; it must not exceed stall_ms, which is {}", motion.poll_ms,
                               motion.stall_ms));
  }
}

void require_frame_size(const CaptureConfig& config) {
  const CameraConfig& camera = config.camera;
  if ((camera.width_px == 0) != (camera.height_px == 0)) {
    refuse_setting(config, camera.width_px == 0 ? "camera.width_px" : "camera.height_px",
                   "is 0 and the other is not; set both, or neither to accept any size");
  }
  if (camera.frames == FrameKind::kPanorama && camera.width_px != 2 * camera.height_px) {
    refuse_setting(config, "camera.width_px",
                   fmt::format("is {} at a height of {}; a panorama is twice as wide as high",
                               camera.width_px, camera.height_px));
  }
}

void require_exposure(const CaptureConfig& config) {
  const ExposureSettings& exposure = config.camera.exposure;
  if (!exposure.lock &&
      (exposure.shutter_s > 0.0 || exposure.iso > 0 || exposure.white_balance_k > 0)) {
    refuse_setting(config, "camera.exposure.lock",
                   "is false, but values to lock are set; leave them out or set it to true");
  }
  const std::vector<double>& bracket_ev = exposure.bracket_ev;
  if (bracket_ev.empty()) {
    refuse_setting(config, "camera.exposure.bracket_ev", "is empty; one exposure is [0]");
  }
  if (std::set<double>(bracket_ev.begin(), bracket_ev.end()).size() != bracket_ev.size()) {
    refuse_setting(config, "camera.exposure.bracket_ev", "holds an exposure twice");
  }
  if (config.run.mode == CaptureMode::kVideo && bracket_ev.size() > 1) {
    refuse_setting(config, "camera.exposure.bracket_ev",
                   "holds more than one exposure, which a video cannot have; write [0]");
  }
}

void require_url(const CaptureConfig& config, std::string_view key, const std::string& url) {
  if (is_http_url(url)) return;
  refuse_setting(config, key,
                 fmt::format("is '{}'; it must be an address such as http://192.168.1.1", url));
}

// Lines are identified by their numbers on the chip, so all must differ.
void require_lines(const CaptureConfig& config) {
  const TriggerConfig& trigger = config.camera.trigger;
  if (trigger.shutter_line < 0) {
    refuse_setting(
        config, "trigger.shutter_line",
        fmt::format("is {}; a gpio camera needs the line of its shutter", trigger.shutter_line));
  }
  if (trigger.chip.empty()) {
    refuse_setting(config, "trigger.chip", "is empty; name the chip, for example gpiochip0");
  }
  if (trigger.focus_line == trigger.shutter_line || trigger.busy_line == trigger.shutter_line) {
    refuse_setting(config, "trigger.shutter_line",
                   fmt::format("is {}, as is another line", trigger.shutter_line));
  }
  if (trigger.busy_line >= 0 && trigger.busy_line == trigger.focus_line) {
    refuse_setting(config, "trigger.busy_line",
                   fmt::format("is {}, as is another line", trigger.busy_line));
  }
}

void require_video_device(const CaptureConfig& config) {
  if (config.camera.v4l2.device.empty()) {
    refuse_setting(config, "camera.v4l2.device",
                   "is missing; name the video device, preferably as /dev/v4l/by-id/...");
  }
}

void require_camera(const CaptureConfig& config) {
  const CameraConfig& camera = config.camera;
  switch (camera.kind) {
    case CameraKind::kOsc:
      require_url(config, "camera.osc.url", camera.osc.url);
      break;
    case CameraKind::kGpio:
      require_lines(config);
      break;
    case CameraKind::kV4l2:
      require_video_device(config);
      break;
  }
  require_frame_size(config);
  require_exposure(config);
  if (config.run.mode == CaptureMode::kVideo && camera.kind != CameraKind::kGpio) {
    refuse_setting(
        config, "run.mode",
        fmt::format("is video, but the program cannot film with the {} camera; film with "
                    "a gpio camera, or capture stations",
                    name_of(camera.kind)));
  }
}

constexpr std::size_t kMaxAddressBytes = 1 << 16;

CheckedJson read_addresses(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) {
    throw UsageError(file.parent_path().string() +
                     ": no simulated rig runs there; start one with raywalk-simulate rig");
  }
  return CheckedJson::parse(read_file(file, kMaxAddressBytes), file.string(),
                            "start the simulated rig again");
}

}  // namespace

CaptureConfig read_capture_config(const std::filesystem::path& file) {
  CaptureConfig config;
  config.file = file;
  config.lines = capture_schema(&config).load(file);
  std::filesystem::path& map = config.slider.register_map;
  if (!map.empty()) map = config_path(map, ConfigKind::kSlider, file.parent_path());
  require_grid(config);
  require_validation(config);
  require_scene(config);
  require_connection(config);
  require_register_map(config);
  require_limits(config);
  require_camera(config);
  if (!config.run.place_url.empty()) require_url(config, "run.place_url", config.run.place_url);
  return config;
}

void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory) {
  if (config->camera.kind != CameraKind::kOsc) {
    refuse_setting(*config, "camera.kind", "the simulated rig's camera is 'osc'");
  }
  try {
    const CheckedJson rig = read_addresses(directory / "rig.json");
    config->slider.device = rig.at("slider").text();
    config->slider.rs485 = false;
    config->slider.host = "127.0.0.1";
    config->slider.port = rig.at("modbus_port").integer(1, 65535);
    config->camera.osc.url = rig.at("camera_url").text();
    config->run.place_url = config->camera.osc.url + "/rig/place";
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

void refuse_setting(const CaptureConfig& config, std::string_view key, const std::string& what) {
  const auto line = config.lines.find(std::string(key));
  const std::string place = line == config.lines.end() ? "" : fmt::format(":{}", line->second);
  throw UsageError(fmt::format("{}{}{}'{}' {}", config.file.string(), place,
                               config.file.empty() ? "" : ": ", key, what));
}

}  // namespace raywalk::capture
