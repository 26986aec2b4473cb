#include "simulator/room/room_settings.h"

#include <fmt/format.h>

#include <limits>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

constexpr double kFarthest_m = 10000.0;

}  // namespace

SettingsSchema virtual_room_schema(VirtualRoomSettings* settings) {
  SettingsSchema schema;
  bind_virtual_scene(&schema, settings, "");
  GridSettings* grid = &settings->grid;
  schema.number("grid.cell_side_m", &grid->cell_side_m, 0.01, 100.0)
      .integer("grid.cells_x", &grid->cells_x, 0, kMostCells)
      .integer("grid.cells_z", &grid->cells_z, 1, kMostCells)
      .number("grid.spacing_mm", &grid->spacing_mm, 0.0, 1e5)
      .number("grid.overhang_share", &grid->overhang_share, 0.0, 2.0)
      .boolean("grid.shared_intersections", &grid->shared_intersections)
      .number("sensor.noise_levels", &settings->sensor.noise_levels, 0.0, 64.0)
      .number("sensor.shot_noise", &settings->sensor.shot_noise, 0.0, 16.0)
      .number("sensor.gain_spread", &settings->sensor.gain_spread, 0.0, 0.5)
      .number("pose.position_jitter_mm", &settings->pose.position_jitter_mm, 0.0, 1000.0)
      .number("pose.attitude_jitter_deg", &settings->pose.attitude_jitter_deg, 0.0, 45.0)
      .integer("output.width_px", &settings->output.width_px, kLeastWidth_px, kLargestWidth_px)
      .choice("output.format", &settings->output.format, {"jpg", "png"})
      .integer("output.jpeg_quality", &settings->output.jpeg_quality, 1, 100)
      .choice("output.jpeg_colour", &settings->output.jpeg_colour, {"full", "quarter"});
  return schema;
}

void bind_virtual_scene(SettingsSchema* schema, VirtualRoomSettings* settings,
                        const std::string& prefix) {
  schema->integer(prefix + "seed", &settings->seed, 0, std::numeric_limits<int>::max())
      .path("scene.file", &settings->scene.file)
      .number("scene.x_m", &settings->scene.middle_m.x(), -kFarthest_m, kFarthest_m)
      .number("scene.y_m", &settings->scene.middle_m.y(), -kFarthest_m, kFarthest_m)
      .number("scene.z_m", &settings->scene.middle_m.z(), -kFarthest_m, kFarthest_m)
      .number(prefix + "light.exposure", &settings->light.exposure, 0.1, 10.0)
      .number(prefix + "light.source_gain", &settings->light.source_gain, 0.1, 100.0)
      .boolean(prefix + "light.clip", &settings->light.clip);
}

void find_scene_beside(const std::filesystem::path& folder, VirtualRoomSettings* settings) {
  std::filesystem::path beside = folder / settings->scene.file;
  std::error_code none;
  if (std::filesystem::is_regular_file(beside, none)) settings->scene.file = std::move(beside);
}

void require_valid(const VirtualRoomSettings& settings, const std::string& source) {
  if (settings.output.width_px % 4 != 0) {
    throw UsageError(fmt::format("{}: the panoramas' width is {}; use a multiple of 4", source,
                                 settings.output.width_px));
  }
}

VirtualRoomSettings read_virtual_room_settings(const std::filesystem::path& file) {
  VirtualRoomSettings settings;
  virtual_room_schema(&settings).load(file);
  find_scene_beside(file.parent_path(), &settings);
  require_valid(settings, file.string());
  return settings;
}

}  // namespace raywalk::simulator
