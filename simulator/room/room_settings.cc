#include "simulator/room/room_settings.h"

#include <fmt/format.h>

#include <limits>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr double kLargestRoom_m = 1000.0;

void bind_grid(SettingsSchema* schema, GridSettings* grid, const std::string& prefix) {
  schema->number(prefix + "cell_side_m", &grid->cell_side_m, 0.01, 100.0)
      .integer(prefix + "cells_x", &grid->cells_x, 1, kMostCells)
      .integer(prefix + "cells_z", &grid->cells_z, 1, kMostCells)
      .number(prefix + "spacing_mm", &grid->spacing_mm, 0.0, 1e5)
      .number(prefix + "overhang_share", &grid->overhang_share, 0.0, 2.0)
      .boolean(prefix + "shared_crossings", &grid->shared_crossings);
}

void bind_room(SettingsSchema* schema, RoomSettings* room, const std::string& prefix) {
  schema->number(prefix + "width_m", &room->width_m, 0.0, kLargestRoom_m)
      .number(prefix + "depth_m", &room->depth_m, 0.0, kLargestRoom_m)
      .number(prefix + "height_m", &room->height_m, 0.0, kLargestRoom_m)
      .number(prefix + "camera_height_m", &room->camera_height_m, 0.0, kLargestRoom_m)
      .number(prefix + "furniture_scale_m", &room->furniture_scale_m, 0.0,
              kLargestFurnitureScale_m);
}

void bind_contents(SettingsSchema* schema, ContentSettings* contents, const std::string& prefix) {
  schema->integer(prefix + "chairs", &contents->chairs, 0, 100)
      .integer(prefix + "pictures", &contents->pictures, 0, 100)
      .boolean(prefix + "table", &contents->table)
      .boolean(prefix + "shelf", &contents->shelf)
      .boolean(prefix + "sofa", &contents->sofa)
      .boolean(prefix + "rug", &contents->rug)
      .boolean(prefix + "plant", &contents->plant)
      .boolean(prefix + "coat_stand", &contents->coat_stand)
      .boolean(prefix + "lamp", &contents->lamp)
      .boolean(prefix + "beams", &contents->beams)
      .boolean(prefix + "skirting", &contents->skirting)
      .boolean(prefix + "mirror", &contents->mirror)
      .boolean(prefix + "window", &contents->window)
      .boolean(prefix + "sun_patch", &contents->sun_patch)
      .boolean(prefix + "wallpaper", &contents->wallpaper)
      .boolean(prefix + "plain_patch", &contents->plain_patch)
      .integer(prefix + "plain_walls", &contents->plain_walls, 0, 4)
      .boolean(prefix + "plain_ceiling", &contents->plain_ceiling)
      .integer(prefix + "glass", &contents->glass, 0, 4);
}

void bind_light(SettingsSchema* schema, LightSettings* light, const std::string& prefix) {
  schema->number(prefix + "exposure", &light->exposure, 0.1, 10.0)
      .number(prefix + "source_gain", &light->source_gain, 0.1, 100.0)
      .boolean(prefix + "clip", &light->clip);
}

void bind_canyon(SettingsSchema* schema, CanyonSettings* canyon, const std::string& prefix) {
  schema->number(prefix + "width_m", &canyon->width_m, 0.0, 100.0)
      .integer(prefix + "stations", &canyon->stations, 2, 10000)
      .number(prefix + "spacing_min_m", &canyon->spacing_min_m, 0.01, 100.0)
      .number(prefix + "spacing_max_m", &canyon->spacing_max_m, 0.01, 100.0)
      .integer(prefix + "cars", &canyon->cars, 0, 100);
}

void bind_ring(SettingsSchema* schema, RingSettings* ring, const std::string& prefix) {
  schema->integer(prefix + "cameras", &ring->cameras, 0, 32)
      .number(prefix + "radius_mm", &ring->radius_mm, 0.0, 1e4)
      .number(prefix + "feather_deg", &ring->feather_deg, 0.0, 90.0)
      .number(prefix + "gain_spread", &ring->gain_spread, 0.0, 0.5)
      .number(prefix + "station_gain_spread", &ring->station_gain_spread, 0.0, 0.5)
      .number(prefix + "vignetting_share", &ring->vignetting_share, 0.0, 0.9);
}

}  // namespace

void bind_virtual_scene(SettingsSchema* schema, VirtualRoomSettings* settings,
                        const std::string& prefix) {
  schema->integer(prefix + "seed", &settings->seed, 0, std::numeric_limits<int>::max());
  bind_room(schema, &settings->room, prefix + "room.");
  bind_contents(schema, &settings->contents, prefix + "contents.");
  bind_light(schema, &settings->light, prefix + "light.");
}

void bind_virtual_room(SettingsSchema* schema, VirtualRoomSettings* settings,
                       const std::string& prefix) {
  bind_virtual_scene(schema, settings, prefix);
  bind_grid(schema, &settings->grid, prefix + "grid.");
  schema->choice(prefix + "place", &settings->place, {"room", "hall", "canyon"});
  schema->integer(prefix + "hall.row_every", &settings->hall.row_every, 2, kMostCells + 1)
      .integer(prefix + "hall.gap_every", &settings->hall.gap_every, 2, kMostCells + 1);
  bind_canyon(schema, &settings->canyon, prefix + "canyon.");
  bind_ring(schema, &settings->ring, prefix + "ring.");
  schema->integer(prefix + "people.count", &settings->people.count, 0, 20)
      .number(prefix + "people.step_mm", &settings->people.step_mm, 0.0, 1e5)
      .number(prefix + "sensor.noise_levels", &settings->sensor.noise_levels, 0.0, 64.0)
      .number(prefix + "sensor.shot_noise", &settings->sensor.shot_noise, 0.0, 16.0)
      .number(prefix + "sensor.gain_spread", &settings->sensor.gain_spread, 0.0, 0.5)
      .number(prefix + "pose.position_jitter_mm", &settings->pose.position_jitter_mm, 0.0, 1000.0)
      .number(prefix + "pose.attitude_jitter_deg", &settings->pose.attitude_jitter_deg, 0.0, 45.0)
      .integer(prefix + "output.width_px", &settings->output.width_px, kLeastWidth_px,
               kLargestWidth_px)
      .choice(prefix + "output.format", &settings->output.format, {"jpg", "png"})
      .integer(prefix + "output.jpeg_quality", &settings->output.jpeg_quality, 1, 100)
      .choice(prefix + "output.jpeg_colour", &settings->output.jpeg_colour, {"full", "quarter"});
}

void require_valid(const VirtualRoomSettings& settings, const std::string& source) {
  if (settings.output.width_px % 4 != 0) {
    throw UsageError(fmt::format("{}: the panoramas' width is {}; use a multiple of 4", source,
                                 settings.output.width_px));
  }
  const RingSettings& ring = settings.ring;
  if (ring.cameras == 1 || (ring.cameras == 0 && ring != RingSettings{})) {
    throw UsageError(fmt::format(
        "{}: ring.cameras is {}; a ring has 2 or more cameras (0: a single camera, without any "
        "other key of ring)",
        source, ring.cameras));
  }
  if (ring.cameras > 0 && ring.feather_deg > 360.0 / ring.cameras) {
    throw UsageError(fmt::format("{}: ring.feather_deg is {:g}; {} cameras are {:g} degrees apart",
                                 source, ring.feather_deg, ring.cameras, 360.0 / ring.cameras));
  }
}

VirtualRoomSettings read_virtual_room_settings(const std::filesystem::path& file) {
  VirtualRoomSettings settings;
  SettingsSchema schema;
  bind_virtual_room(&schema, &settings, "");
  schema.load(file);
  require_valid(settings, file.string());
  return settings;
}

}  // namespace raywalk::capture
