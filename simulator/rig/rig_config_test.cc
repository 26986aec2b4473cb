#include "simulator/rig/rig_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::simulator {
namespace {

using ::testing::HasSubstr;

constexpr const char* kShipped = RAYWALK_CONFIGS "/simulated-rig.yaml";

RigConfig parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "rig.yaml", yaml);
  return read_rig_config(directory / "rig.yaml");
}

void expect_refused(const std::string& yaml, const std::string& message) {
  try {
    parsed("capture_config: capture.yaml\n" + yaml);
    ADD_FAILURE() << yaml;
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr(message));
    EXPECT_THAT(e.what(), HasSubstr("rig.yaml"));
  }
}

TEST(RigConfigTest, ShippedFileHoldsEveryKeyWithItsDefault) {
  RigConfig defaults;
  auto values = rig_schema(&defaults).values();
  std::set<std::string> known;
  for (const auto& entry : values) known.insert(entry.first);
  std::set<std::string> held = keys_of_yaml(kShipped);
  EXPECT_EQ(held, known);
  RigConfig shipped = read_rig_config(kShipped);
  EXPECT_EQ(shipped.capture_config.filename(), "capture-osc.yaml");
  EXPECT_TRUE(std::filesystem::exists(shipped.capture_config));
  shipped.capture_config.clear();
  EXPECT_EQ(rig_schema(&shipped).values(), values);
}

TEST(RigConfigTest, FaultsAreReadInTheirOrder) {
  const RigConfig shipped = read_rig_config(kShipped);
  ASSERT_EQ(shipped.faults.size(), 4U);
  EXPECT_EQ(shipped.faults[0].kind, RigFault::kStall);
  EXPECT_EQ(shipped.faults[0].at_station, "x0_002");
  EXPECT_EQ(shipped.faults[0].after_ms, 100.0);
  EXPECT_EQ(shipped.faults[1].at_request, 500);
  EXPECT_EQ(shipped.faults[2].at_picture, 3);
  EXPECT_EQ(shipped.faults[3].at_s, 60.0);
  EXPECT_EQ(shipped.faults[3].amount, 2.5);
}

TEST(RigConfigTest, EveryGroupIsRead) {
  const RigConfig config = parsed(
      "capture_config: sub/capture.yaml\nscene:\n  seed: 7\n  file: hall\n  x_m: 3\n"
      "slider:\n  backlash_mm: 0.5\n  tcp_port: 1502\nrail:\n"
      "  sag_mm: 3\n  jitter_mm: 0.7\nlink:\n  late: 0.02\ncamera:\n  layout: dual-fisheye\n"
      "  lens: lenses/mine.yaml\n  vignetting: 0.3\n  noise_levels: 2\ndolly:\n"
      "  visible: true\ntruth:\n  views: 5\n");
  EXPECT_THAT(config.capture_config.string(), ::testing::EndsWith("/sub/capture.yaml"));
  EXPECT_EQ(config.scene.seed, 7);
  EXPECT_EQ(config.scene.scene.file, "hall");
  EXPECT_EQ(config.scene.scene.middle_m.x(), 3.0);
  EXPECT_EQ(config.slider.backlash_mm, 0.5);
  EXPECT_EQ(config.tcp_port, 1502);
  EXPECT_EQ(config.rail.sag_mm, 3.0);
  EXPECT_EQ(config.rail.jitter_mm, 0.7);
  EXPECT_EQ(config.link.late, 0.02);
  EXPECT_EQ(config.camera.layout, FrameKind::kDualFisheye);
  EXPECT_THAT(config.camera.lens.string(), ::testing::EndsWith("/lenses/mine.yaml"));
  EXPECT_TRUE(config.camera.lens.has_parent_path());
  EXPECT_EQ(config.camera.light.vignetting, 0.3);
  EXPECT_EQ(config.camera.sensor.noise_levels, 2.0);
  EXPECT_TRUE(config.dolly.visible);
  EXPECT_EQ(config.truth.views, 5);
}

TEST(RigConfigTest, MistakesAreNamed) {
  EXPECT_THROW(parsed("scene:\n  seed: 1\n"), UsageError);
  expect_refused("slider:\n  backlash: 1\n", ":3: unknown key 'slider.backlash'");
  expect_refused("slider:\n  power_on_mm: -30\n", "between the switches");
  expect_refused("link:\n  late: 0.6\n  lost: 0.6\n", "more than 1");
  expect_refused("camera:\n  width_px: 66\n", "multiple of 4");
  expect_refused("truth:\n  width_px: 66\n", "multiple of 4");
  expect_refused("camera:\n  vignetting: 0.2\n", "'camera.layout: dual-fisheye'");
  expect_refused("camera:\n  lens: lens.yaml\n", "'camera.layout: dual-fisheye'");
  expect_refused("dolly:\n  reach_deg: 80\n", "dolly.reach_deg");
  expect_refused("scene:\n  grid:\n    cells_x: 2\n", "unknown key");
  expect_refused("faults:\n  - kind: stal\n    at_s: 1\n", "did you mean 'stall'");
}

TEST(RigConfigTest, FaultsMustHaveAValidTrigger) {
  expect_refused("faults:\n  - kind: stall\n", "faults[0] needs exactly one of at_request");
  expect_refused("faults:\n  - kind: stall\n    at_s: 1\n    at_station: x0_001\n", "exactly one");
}

}  // namespace
}  // namespace raywalk::simulator
