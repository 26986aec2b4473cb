#include "simulator/room/room_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::simulator {
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

// The shipped file claims that its values are the defaults.
TEST(RoomSettingsTest, ShippedFileHoldsEveryKeyWithItsDefault) {
  constexpr const char* kShipped = RAYWALK_CONFIGS "/virtual-room.yaml";
  VirtualRoomSettings defaults = parsed(""), shipped = read_virtual_room_settings(kShipped);
  const auto values = virtual_room_schema(&defaults).values();
  EXPECT_EQ(virtual_room_schema(&shipped).values(), values);
  std::set<std::string> known;
  for (const auto& entry : values) known.insert(entry.first);
  EXPECT_EQ(keys_of_yaml(kShipped), known);
}

TEST(RoomSettingsTest, EveryGroupIsRead) {
  const VirtualRoomSettings settings = parsed(
      "seed: 7\nscene:\n  file: hall\n  y_m: 0.2\ngrid:\n  cell_side_m: 0.5\n  cells_x: 2\n"
      "light:\n  clip: true\nsensor:\n  gain_spread: 0.1\npose:\n  position_jitter_mm: 2\noutput:\n"
      "  format: png\n");
  EXPECT_EQ(settings.seed, 7);
  EXPECT_EQ(settings.grid.cell_side_m, 0.5);
  EXPECT_EQ(settings.grid.cells_x, 2);
  EXPECT_EQ(settings.scene.file, "hall");
  EXPECT_EQ(settings.scene.middle_m, Eigen::Vector3d(0, 0.2, 0));
  EXPECT_TRUE(settings.light.clip);
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
}

TEST(RoomSettingsTest, ScenesBesideTheSettingsAreFound) {
  const TestDirectory directory;
  write_file_atomically(directory / "mine.yaml", "");
  write_file_atomically(directory / "room.yaml", "scene: {file: mine.yaml}\n");
  EXPECT_EQ(read_virtual_room_settings(directory / "room.yaml").scene.file,
            directory / "mine.yaml");
}

}  // namespace
}  // namespace raywalk::simulator
