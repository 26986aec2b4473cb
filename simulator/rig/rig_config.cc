#include "simulator/rig/rig_config.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/files/shipped_configs.h"

namespace raywalk::simulator {
namespace {

constexpr int kAnySeed = std::numeric_limits<int>::max();
constexpr int kLargestPort = 65535;
constexpr double kLongest_ms = 1e9;
constexpr std::size_t kMostFaults = 10000;

void bind_slider(SettingsSchema* schema, RigConfig* config) {
  DriveSettings* slider = &config->slider;
  schema->integer("slider.seed", &slider->seed, 0, kAnySeed)
      .integer("slider.tcp_port", &config->tcp_port, 0, kLargestPort)
      .number("slider.low_switch_mm", &slider->low_switch_mm, -1e5, 0.0)
      .number("slider.high_switch_mm", &slider->high_switch_mm, 1.0, 1e5)
      .number("slider.power_on_mm", &slider->power_on_mm, -1e5, 1e5)
      .number("slider.max_speed_mm_s", &slider->max_speed_mm_s, 0.1, 1e6)
      .number("slider.max_acceleration_mm_s2", &slider->max_acceleration_mm_s2, 0.1, 1e7)
      .number("slider.homing_speed_mm_s", &slider->homing_speed_mm_s, 0.1, 1e6)
      .number("slider.backlash_mm", &slider->backlash_mm, 0.0, 100.0)
      .number("slider.feedback_noise_mm", &slider->feedback_noise_mm, 0.0, 100.0);
}

void bind_link(SettingsSchema* schema, LinkSettings* link) {
  schema->integer("link.seed", &link->seed, 0, kAnySeed)
      .number("link.late", &link->late, 0.0, 1.0)
      .number("link.lost", &link->lost, 0.0, 1.0)
      .number("link.corrupted", &link->corrupted, 0.0, 1.0)
      .number("link.duplicated", &link->duplicated, 0.0, 1.0)
      .number("link.late_ms", &link->late_ms, 0.0, kLongest_ms);
}

void bind_rail(SettingsSchema* schema, RailSettings* rail) {
  schema->integer("rail.seed", &rail->seed, 0, kAnySeed)
      .number("rail.placing_spread_mm", &rail->placing_spread_mm, 0.0, 1000.0)
      .number("rail.direction_spread_deg", &rail->direction_spread_deg, 0.0, 45.0)
      .number("rail.tilt_spread_deg", &rail->tilt_spread_deg, 0.0, 45.0)
      .number("rail.sag_mm", &rail->sag_mm, -1000.0, 1000.0)
      .number("rail.bow_mm", &rail->bow_mm, -1000.0, 1000.0)
      .number("rail.attitude_spread_deg", &rail->attitude_spread_deg, 0.0, 45.0)
      .number("rail.twist_deg", &rail->twist_deg, -45.0, 45.0)
      .number("rail.jitter_mm", &rail->jitter_mm, 0.0, 1000.0)
      .number("rail.jitter_deg", &rail->jitter_deg, 0.0, 45.0)
      .number("rail.vibration_mm", &rail->vibration_mm, 0.0, 1000.0)
      .number("rail.vibration_hz", &rail->vibration_hz, 0.0, 1000.0)
      .number("rail.vibration_decay_ms", &rail->vibration_decay_ms, 0.1, kLongest_ms);
}

void bind_camera(SettingsSchema* schema, RigCameraSettings* camera) {
  schema->integer("camera.port", &camera->port, 0, kLargestPort)
      .choice("camera.layout", &camera->layout, capture::kFrameKinds)
      .path("camera.lens", &camera->lens)
      .number("camera.vignetting", &camera->light.vignetting, 0.0, 0.9)
      .number("camera.lens_gain_ev", &camera->light.lens_gain_ev, -5.0, 5.0)
      .integer("camera.width_px", &camera->width_px, kLeastWidth_px, kLargestWidth_px)
      .integer("camera.jpeg_quality", &camera->jpeg_quality, 1, 100)
      .number("camera.render_ahead_within_mm", &camera->render_ahead_within_mm, 0.0, 10.0)
      .number("camera.exposure_ms", &camera->exposure_ms, 0.0, kLongest_ms)
      .number("camera.clock_offset_s", &camera->clock_offset_s, -1e9, 1e9)
      .number("camera.card_mb", &camera->card_mb, 0.0, 1e7)
      .number("camera.automatic_wander_ev", &camera->automatic_wander_ev, 0.0, 5.0)
      .number("camera.exposure_drift_ev", &camera->exposure_drift_ev, 0.0, 5.0)
      .number("camera.noise_levels", &camera->sensor.noise_levels, 0.0, 64.0)
      .number("camera.shot_noise", &camera->sensor.shot_noise, 0.0, 16.0);
}

void require_valid(const RigConfig& config, const std::string& source) {
  const auto refuse = [&source](const std::string& what) {
    throw UsageError(source + ": " + what);
  };
  if (config.capture_config.empty()) {
    refuse("'capture_config' is missing; set it to the capture configuration that the rig is for");
  }
  const DriveSettings& slider = config.slider;
  if (slider.power_on_mm < slider.low_switch_mm || slider.power_on_mm > slider.high_switch_mm) {
    refuse(fmt::format("'slider.power_on_mm' is {}; it must lie between the switches at {} and {}",
                       slider.power_on_mm, slider.low_switch_mm, slider.high_switch_mm));
  }
  const LinkSettings& link = config.link;
  if (link.late + link.lost + link.corrupted + link.duplicated > 1.0) {
    refuse("the shares of 'link' (late, lost, corrupted, duplicated) add up to more than 1");
  }
  for (const auto& [key, width_px] : {std::pair{"camera.width_px", config.camera.width_px},
                                      std::pair{"truth.width_px", config.truth.width_px}}) {
    if (width_px % 4 != 0) {
      refuse(fmt::format("'{}' is {}; use a multiple of 4", key, width_px));
    }
  }
  const bool lenses_matter = config.camera.layout == FrameKind::kDualFisheye;
  if (!lenses_matter && (!config.camera.lens.empty() || !config.camera.light.is_even())) {
    refuse(
        "'camera.lens', 'camera.vignetting' and 'camera.lens_gain_ev' require "
        "'camera.layout: dual-fisheye'");
  }
  for (std::size_t i = 0; i < config.faults.size(); ++i) {
    if (triggers_of(config.faults[i]) == 1) continue;
    refuse(fmt::format("faults[{}] needs exactly one of at_request, at_picture, at_station or at_s",
                       i));
  }
}

}  // namespace

SettingsSchema rig_schema(RigConfig* config) {
  SettingsSchema schema;
  schema.path("capture_config", &config->capture_config);
  bind_virtual_scene(&schema, &config->scene, "scene.");
  bind_slider(&schema, config);
  bind_rail(&schema, &config->rail);
  bind_link(&schema, &config->link);
  bind_camera(&schema, &config->camera);
  schema.boolean("dolly.visible", &config->dolly.visible)
      .number("dolly.reach_deg", &config->dolly.reach_deg, 10.0, 45.0);
  schema
      .items(
          "faults",
          [config] {
            config->faults.emplace_back();
            return fault_schema(&config->faults.back());
          },
          kMostFaults)
      .integer("truth.distance_every", &config->truth.distance_every, 0, 1000000)
      .integer("truth.width_px", &config->truth.width_px, 0, kLargestWidth_px)
      .integer("truth.views", &config->truth.views, 0, 10000);
  return schema;
}

RigConfig read_rig_config(const std::filesystem::path& file) {
  RigConfig config;
  rig_schema(&config).load(file);
  require_valid(config, file.string());
  const std::filesystem::path folder = file.parent_path();
  find_scene_beside(folder, &config.scene);
  config.capture_config = config_path(config.capture_config, ConfigKind::kCapture, folder);
  if (!config.camera.lens.empty()) {
    config.camera.lens = config_path(config.camera.lens, ConfigKind::kLens, folder);
  }
  return config;
}

}  // namespace raywalk::simulator
