#include "capture/config/capture_schema.h"

#include <array>
#include <cstddef>

namespace raywalk::capture {
namespace {

constexpr double kMaxLength_m = 1000.0;  // of anything in the plan
constexpr double kMaxLength_mm = 1e6;
constexpr double kMaxTime_ms = 3.6e6;
constexpr int kMaxCells = 1000;  // along a side
constexpr int kMaxPlacements = 1000;
constexpr std::size_t kMaxValidationLines = 100;
constexpr std::size_t kMaxExposures = 9;

void bind_grid(SettingsSchema* schema, CaptureGrid* grid) {
  schema->number("grid.cell_side_m", &grid->cell_side_m, 0.01, 100.0)
      .integer("grid.cells_x", &grid->cells_x, 1, kMaxCells)
      .integer("grid.cells_z", &grid->cells_z, 1, kMaxCells)
      .number("grid.spacing_mm", &grid->spacing_mm, 0.1, 1e5)
      .number("grid.k_deg", &grid->k_deg, 45.0, 90.0)
      .number("grid.blend_deg", &grid->blend_deg, 0.0, 45.0)
      .number("grid.overhang_mm", &grid->overhang_mm, -1.0, 1e5);
}

SettingsSchema validation_schema(ValidationLine* line) {
  SettingsSchema schema;
  schema.choice("axis", &line->axis, std::array{LineAxis::kX, LineAxis::kZ})
      .number("across_m", &line->across_m, -kMaxLength_m, kMaxLength_m)
      .number("from_m", &line->from_m, -kMaxLength_m, kMaxLength_m)
      .number("to_m", &line->to_m, -kMaxLength_m, kMaxLength_m)
      .number("spacing_mm", &line->spacing_mm, 0.1, 1e5);
  return schema;
}

void bind_scene(SettingsSchema* schema, CaptureScene* scene) {
  schema->number("scene.nearest_m", &scene->nearest_m, 0.0, 1e5)
      .number("scene.farthest_m", &scene->farthest_m, 0.0, 1e9)
      .number("scene.tolerance_px", &scene->tolerance_px, 0.01, 100.0);
}

void bind_motion(SettingsSchema* schema, MotionRules* motion) {
  schema->number("slider.motion.speed_mm_s", &motion->profile.speed_mm_s, 0.01, 1e4)
      .number("slider.motion.acceleration_mm_s2", &motion->profile.acceleration_mm_s2, 0.01, 1e6)
      .number("slider.motion.settle_tolerance_mm", &motion->settle_tolerance_mm, 0.001, 100.0)
      .number("slider.motion.settle_ms", &motion->settle_ms, 0.0, kMaxTime_ms)
      .number("slider.motion.settle_timeout_ms", &motion->settle_timeout_ms, 1.0, kMaxTime_ms)
      .number("slider.motion.following_error_mm", &motion->following_error_mm, 0.01, 1000.0)
      .number("slider.motion.stall_ms", &motion->stall_ms, 1.0, kMaxTime_ms)
      .number("slider.motion.poll_ms", &motion->poll_ms, 0.1, 1000.0)
      .number("slider.motion.homing_timeout_ms", &motion->homing_timeout_ms, 1.0, kMaxTime_ms);
}

void bind_slider(SettingsSchema* schema, SliderConfig* slider) {
  schema->choice("slider.connection", &slider->connection, kSliderConnections)
      .text("slider.device", &slider->device)
      .integer("slider.baud", &slider->baud, 50, 4000000)
      .choice("slider.parity", &slider->parity, kSerialParities)
      .integer("slider.stop_bits", &slider->stop_bits, 1, 2)
      .boolean("slider.rs485", &slider->rs485)
      .text("slider.host", &slider->host)
      .integer("slider.port", &slider->port, 1, 65535)
      .integer("slider.unit", &slider->unit, 1, 255)
      .number("slider.response_timeout_ms", &slider->response_timeout_ms, 1.0, kMaxTime_ms)
      .number("slider.byte_timeout_ms", &slider->byte_timeout_ms, 1.0, kMaxTime_ms)
      .integer("slider.tries", &slider->tries, 1, 100)
      .path("slider.register_map", &slider->register_map)
      .number("slider.low_limit_mm", &slider->low_limit_mm, -kMaxLength_mm, kMaxLength_mm)
      .number("slider.high_limit_mm", &slider->high_limit_mm, -kMaxLength_mm, kMaxLength_mm)
      .number("slider.first_station_mm", &slider->first_station_mm, -kMaxLength_mm, kMaxLength_mm)
      .integer("slider.placements_per_line", &slider->placements_per_line, 1, kMaxPlacements);
  bind_motion(schema, &slider->motion);
}

void bind_camera(SettingsSchema* schema, CameraConfig* camera) {
  schema->choice("camera.kind", &camera->kind, kCameraKinds)
      .choice("camera.frames", &camera->frames, kFrameKinds)
      .integer("camera.width_px", &camera->width_px, 0, 65536)
      .integer("camera.height_px", &camera->height_px, 0, 65536)
      .boolean("camera.exposure.lock", &camera->exposure.lock)
      .number("camera.exposure.shutter_s", &camera->exposure.shutter_s, 0.0, 3600.0)
      .integer("camera.exposure.iso", &camera->exposure.iso, 0, 10000000)
      .integer("camera.exposure.white_balance_k", &camera->exposure.white_balance_k, 0, 100000)
      .numbers("camera.exposure.bracket_ev", &camera->exposure.bracket_ev, -10.0, 10.0,
               kMaxExposures)
      .number("camera.card_gb", &camera->card_gb, 0.0, 1e6)
      .integer("camera.battery_pictures", &camera->battery_pictures, 0, 1000000)
      .number("camera.battery_min", &camera->battery_min, 0.0, 1e5)
      .text("camera.osc.url", &camera->osc.url)
      .number("camera.osc.connect_timeout_ms", &camera->osc.connect_timeout_ms, 1.0, kMaxTime_ms)
      .number("camera.osc.picture_timeout_ms", &camera->osc.picture_timeout_ms, 1.0, kMaxTime_ms)
      .number("camera.osc.poll_ms", &camera->osc.poll_ms, 1.0, 10000.0)
      .text("camera.v4l2.device", &camera->v4l2.device)
      .choice("camera.v4l2.pixel_format", &camera->v4l2.pixel_format, kPixelFormats)
      .number("camera.v4l2.frame_timeout_ms", &camera->v4l2.frame_timeout_ms, 1.0, kMaxTime_ms)
      .number("camera.v4l2.exposure_ms", &camera->v4l2.exposure_ms, 0.0, kMaxTime_ms)
      .integer("camera.v4l2.jpeg_quality", &camera->v4l2.jpeg_quality, 1, 100);
}

void bind_trigger(SettingsSchema* schema, TriggerConfig* trigger) {
  schema->text("trigger.chip", &trigger->chip)
      .integer("trigger.focus_line", &trigger->focus_line, -1, 65535)
      .integer("trigger.shutter_line", &trigger->shutter_line, -1, 65535)
      .integer("trigger.busy_line", &trigger->busy_line, -1, 65535)
      .boolean("trigger.active_low", &trigger->active_low)
      .boolean("trigger.busy_active_low", &trigger->busy_active_low)
      .number("trigger.focus_ms", &trigger->focus_ms, 0.0, kMaxTime_ms)
      .number("trigger.pulse_ms", &trigger->pulse_ms, 1.0, kMaxTime_ms)
      .boolean("trigger.press_per_exposure", &trigger->press_per_exposure)
      .number("trigger.hold_ms", &trigger->hold_ms, 0.0, kMaxTime_ms)
      .number("trigger.busy_start_timeout_ms", &trigger->busy_start_timeout_ms, 1.0, kMaxTime_ms)
      .number("trigger.busy_end_timeout_ms", &trigger->busy_end_timeout_ms, 1.0, kMaxTime_ms);
}

void bind_run(SettingsSchema* schema, RunConfig* run) {
  schema->choice("run.mode", &run->mode, kCaptureModes)
      .number("run.video_speed_mm_s", &run->video_speed_mm_s, 0.01, 1e4)
      .integer("run.shots", &run->shots, 1, 100)
      .number("run.approach_mm", &run->approach_mm, 0.0, 1000.0)
      .number("run.least_free_mb", &run->least_free_mb, 0.0, 1e9)
      .number("run.picture_mb", &run->picture_mb, 0.0, 1e5)
      .number("run.picture_s", &run->picture_s, 0.0, 3600.0)
      .number("run.placing_s", &run->placing_s, 0.0, 86400.0)
      .number("run.work_h_per_day", &run->work_h_per_day, 0.0, 24.0)
      .number("run.battery_change_s", &run->battery_change_s, 0.0, 86400.0)
      .text("run.place_url", &run->place_url)
      .number("run.place_timeout_ms", &run->place_timeout_ms, 1.0, kMaxTime_ms);
}

}  // namespace

SettingsSchema capture_schema(CaptureConfig* config) {
  SettingsSchema schema;
  bind_grid(&schema, &config->grid);
  schema.items(
      "validation", [config] { return validation_schema(&config->validation.emplace_back()); },
      kMaxValidationLines);
  bind_scene(&schema, &config->scene);
  bind_slider(&schema, &config->slider);
  bind_camera(&schema, &config->camera);
  bind_trigger(&schema, &config->camera.trigger);
  bind_run(&schema, &config->run);
  return schema;
}

}  // namespace raywalk::capture
