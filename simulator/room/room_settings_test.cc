#include "simulator/room/room_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using ::testing::HasSubstr;

VirtualRoomSettings parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "room.yaml", yaml);
  return read_virtual_room_settings(directory / "room.yaml");
}

void expect_refused(const std::string& yaml, const std::string& message) {
  try {
    parsed(yaml);
    ADD_FAILURE() << yaml;
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr(message));
  }
}

TEST(RoomSettingsTest, EmptyFileGivesTheDefaults) { EXPECT_EQ(parsed(""), VirtualRoomSettings{}); }

// The shipped file claims that its values are the defaults.
TEST(RoomSettingsTest, ShippedFileHoldsEveryKeyWithItsDefault) {
  const std::string yaml = read_file(RAYWALK_CONFIGS "/virtual-room.yaml");
  const VirtualRoomSettings shipped =
      read_virtual_room_settings(RAYWALK_CONFIGS "/virtual-room.yaml");
  EXPECT_EQ(shipped, VirtualRoomSettings{});
  for (const char* key : {"seed",
                          "cell_side_m",
                          "cells_x",
                          "cells_z",
                          "spacing_mm",
                          "overhang_share",
                          "shared_crossings",
                          "row_every",
                          "gap_every",
                          "width_m",
                          "depth_m",
                          "height_m",
                          "camera_height_m",
                          "furniture_scale_m",
                          "chairs",
                          "pictures",
                          "table",
                          "shelf",
                          "sofa",
                          "rug",
                          "plant",
                          "coat_stand",
                          "lamp",
                          "beams",
                          "skirting",
                          "mirror",
                          "window",
                          "sun_patch",
                          "wallpaper",
                          "plain_patch",
                          "place",
                          "stations",
                          "spacing_min_m",
                          "spacing_max_m",
                          "cars",
                          "plain_walls",
                          "plain_ceiling",
                          "glass",
                          "exposure",
                          "source_gain",
                          "clip",
                          "cameras",
                          "radius_mm",
                          "feather_deg",
                          "station_gain_spread",
                          "vignetting_share",
                          "jpeg_colour",
                          "count",
                          "step_mm",
                          "noise_levels",
                          "shot_noise",
                          "gain_spread",
                          "position_jitter_mm",
                          "attitude_jitter_deg",
                          "width_px",
                          "format",
                          "jpeg_quality"}) {
    EXPECT_THAT(yaml, HasSubstr(std::string(key) + ": ")) << key;
  }
}

TEST(RoomSettingsTest, EveryGroupIsRead) {
  const VirtualRoomSettings settings = parsed(
      "seed: 7\ngrid:\n  cell_side_m: 0.5\n  cells_x: 2\nroom:\n  height_m: 3\ncontents:\n"
      "  lamp: false\nsensor:\n  gain_spread: 0.1\npose:\n  position_jitter_mm: 2\noutput:\n"
      "  format: png\n");
  EXPECT_EQ(settings.seed, 7);
  EXPECT_EQ(settings.grid.cell_side_m, 0.5);
  EXPECT_EQ(settings.grid.cells_x, 2);
  EXPECT_EQ(settings.room.height_m, 3.0);
  EXPECT_FALSE(settings.contents.lamp);
  EXPECT_EQ(settings.sensor.gain_spread, 0.1);
  EXPECT_EQ(settings.pose.position_jitter_mm, 2.0);
  EXPECT_EQ(settings.output.format, "png");
}

TEST(RoomSettingsTest, MistakesAreNamedWithTheirLine) {
  expect_refused("seed: 1\ngrid:\n  cell_side: 1\n", ":3: unknown key 'grid.cell_side'");
  expect_refused("grid:\n  cell_side_m: 0\n", "must lie between");
  expect_refused("seed: -1\n", "must lie between");
  expect_refused("output:\n  format: bmp\n", "is not a valid choice");
  expect_refused("output:\n  width_px: 130\n", "multiple of 4");
  expect_refused("ring:\n  radius_mm: 100\n", "ring.cameras is 0");
  expect_refused("ring:\n  cameras: 1\n", "ring.cameras is 1");
  expect_refused("ring:\n  cameras: 8\n  feather_deg: 50\n", "8 cameras are 45 degrees apart");
  expect_refused("contents:\n  chairs: many\n", "must be a whole number");
}

TEST(RoomSettingsTest, KeysCanBePartOfALargerFile) {
  VirtualRoomSettings settings;
  SettingsSchema schema;
  bind_virtual_room(&schema, &settings, "scene.");
  schema.parse("scene:\n  grid:\n    cells_z: 3\n", "rig.yaml");
  EXPECT_EQ(settings.grid.cells_z, 3);
}

}  // namespace
}  // namespace raywalk::capture
