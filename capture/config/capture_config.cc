#include "capture/config/capture_config.h"

#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "capture/base/http_url.h"
#include "capture/config/capture_schema.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/shipped_configs.h"

namespace raywalk::capture {
namespace {

// A setting that contradicts another, or lacks what another needs.
struct Rule {
  bool broken = false;
  std::string key{};
  std::string what{};  // is wrong with its value
};

std::vector<Rule> plan_rules(const CaptureConfig& config) {
  const double overhang_mm = config.grid.overhang_mm;
  const CaptureScene& scene = config.scene;
  std::vector<Rule> rules{
      {overhang_mm < 0.0 && overhang_mm != -1.0, "grid.overhang_mm",
       fmt::format("is {}; it must be 0 or more, or -1 for as much as k_deg needs", overhang_mm)}};
  for (std::size_t i = 0; i < config.validation.size(); ++i) {
    const ValidationLine& line = config.validation[i];
    rules.push_back(
        {!(line.from_m < line.to_m), fmt::format("validation[{}].to_m", i),
         fmt::format("is {}; it must be larger than from_m, which is {}", line.to_m, line.from_m)});
  }
  rules.push_back({scene.farthest_m > 0.0 && scene.farthest_m < scene.nearest_m, "scene.farthest_m",
                   fmt::format("is {}; it must not be below nearest_m, which is {}",
                               scene.farthest_m, scene.nearest_m)});
  return rules;
}

std::vector<Rule> slider_rules(const CaptureConfig& config) {
  const SliderConfig& slider = config.slider;
  const MotionRules& motion = slider.motion;
  return {
      {!(slider.low_limit_mm < slider.high_limit_mm), "slider.high_limit_mm",
       fmt::format("is {}; it must be above low_limit_mm, which is {}", slider.high_limit_mm,
                   slider.low_limit_mm)},
      {motion.following_error_mm < motion.settle_tolerance_mm, "slider.motion.following_error_mm",
       fmt::format("is {}; it must not be below settle_tolerance_mm, which is {}",
                   motion.following_error_mm, motion.settle_tolerance_mm)},
      {motion.poll_ms > motion.stall_ms, "slider.motion.poll_ms",
       fmt::format("is {}; it must not exceed stall_ms, which is {}", motion.poll_ms,
                   motion.stall_ms)},
  };
}

// What the drive needs to be reached.
std::vector<Rule> drive_rules(const SliderConfig& slider) {
  const std::filesystem::path& map = slider.register_map;
  const auto impossible = impossible_connection(slider);
  std::error_code unreadable;
  std::string map_fault;
  if (map.empty()) {
    map_fault = "is missing; name the map of the drive's registers, for example leadshine-pr0";
  } else if (!std::filesystem::is_regular_file(map, unreadable)) {
    map_fault = missing_config_text(map, ConfigKind::kSlider);
  }
  return {
      {impossible.has_value(), impossible ? impossible->key : "",
       impossible ? impossible->what : ""},
      {!map_fault.empty(), "slider.register_map", map_fault},
  };
}

Rule url_rule(const std::string& key, const std::string& url) {
  return {!is_http_url(url), key,
          fmt::format("is '{}'; it must be an address such as http://192.168.1.1", url)};
}

// What the kind of camera needs to be reached.
std::vector<Rule> device_rules(const CameraConfig& camera) {
  const TriggerConfig& trigger = camera.trigger;
  switch (camera.kind) {
    case CameraKind::kOsc:
      return {url_rule("camera.osc.url", camera.osc.url)};
    case CameraKind::kV4l2:
      return {{camera.v4l2.device.empty(), "camera.v4l2.device",
               "is missing; name the video device, preferably as /dev/v4l/by-id/..."}};
    case CameraKind::kGpio:
      break;
  }
  // Lines are identified by their numbers on the chip, so all must differ.
  return {
      {trigger.shutter_line < 0, "trigger.shutter_line",
       fmt::format("is {}; a gpio camera needs the line of its shutter", trigger.shutter_line)},
      {trigger.chip.empty(), "trigger.chip", "is empty; name the chip, for example gpiochip0"},
      {trigger.focus_line == trigger.shutter_line || trigger.busy_line == trigger.shutter_line,
       "trigger.shutter_line", fmt::format("is {}, as is another line", trigger.shutter_line)},
      {trigger.busy_line >= 0 && trigger.busy_line == trigger.focus_line, "trigger.busy_line",
       fmt::format("is {}, as is another line", trigger.busy_line)},
  };
}

std::vector<Rule> picture_rules(const CaptureConfig& config) {
  const CameraConfig& camera = config.camera;
  const ExposureSettings& exposure = camera.exposure;
  const std::set<double> different(exposure.bracket_ev.begin(), exposure.bracket_ev.end());
  const bool is_video = config.run.mode == CaptureMode::kVideo;
  return {
      {(camera.width_px == 0) != (camera.height_px == 0),
       camera.width_px == 0 ? "camera.width_px" : "camera.height_px",
       "is 0 and the other is not; set both, or neither to accept any size"},
      {camera.frames == FrameKind::kPanorama && camera.width_px != 2 * camera.height_px,
       "camera.width_px",
       fmt::format("is {} at a height of {}; a panorama is twice as wide as high", camera.width_px,
                   camera.height_px)},
      {!exposure.lock &&
           (exposure.shutter_s > 0.0 || exposure.iso > 0 || exposure.white_balance_k > 0),
       "camera.exposure.lock",
       "is false, but values to lock are set; leave them out or set it to true"},
      {different.empty(), "camera.exposure.bracket_ev", "is empty; one exposure is [0]"},
      {different.size() != exposure.bracket_ev.size(), "camera.exposure.bracket_ev",
       "holds an exposure twice"},
      {is_video && different.size() > 1, "camera.exposure.bracket_ev",
       "holds more than one exposure, which a video cannot have; write [0]"},
      {is_video && camera.kind != CameraKind::kGpio, "run.mode",
       fmt::format("is video, but the program cannot record video with the {} camera; record it "
                   "with a gpio "
                   "camera, or capture stations",
                   name_of(camera.kind))},
  };
}

// Refuses the first broken rule.
void require(const CaptureConfig& config, const std::vector<Rule>& rules) {
  for (const Rule& rule : rules) {
    if (rule.broken) refuse_setting(config, rule.key, rule.what);
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
  require(config, plan_rules(config));
  require(config, slider_rules(config));
  require(config, picture_rules(config));
  return config;
}

void require_devices(const CaptureConfig& config) {
  require(config, drive_rules(config.slider));
  require(config, device_rules(config.camera));
  const std::string& place_url = config.run.place_url;
  if (!place_url.empty()) require(config, {url_rule("run.place_url", place_url)});
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
