#include "simulator/rig/rig_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/lens_file.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"
#include "simulator/rig/rig_optics.h"

namespace raywalk::simulator {
namespace {

using namespace capture;
namespace fs = std::filesystem;
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

// --- The rehearsal and the lenses that are shipped
// ------------------------------------------------

const fs::path kConfigs = RAYWALK_CONFIGS;

// Largest distance in pixels between the images of the same direction in two lenses, up to 90
// degrees off the axis.
double largest_difference_px(const FisheyeLens& a, const FisheyeLens& b) {
  double largest = 0.0;
  for (double t = 0.0; t <= kHalfPi; t += 0.1) {
    for (double around = 0.0; around < kTwoPi; around += 0.3) {
      const Eigen::Vector3d direction(std::sin(t) * std::cos(around),
                                      std::sin(t) * std::sin(around), std::cos(t));
      const PixelPosition at_a = *project(a, direction), at_b = *project(b, direction);
      largest = std::max(largest, std::hypot(at_a.u - at_b.u, at_a.v - at_b.v));
    }
  }
  return largest;
}

void expect_inside(const FisheyeLens& lens, PanoramaSize picture) {
  for (double around = 0.0; around < kTwoPi; around += 0.1) {
    const double t = 0.999 * lens.largest_angle_rad;
    const PixelPosition rim = *project(
        lens, {std::sin(t) * std::cos(around), std::sin(t) * std::sin(around), std::cos(t)});
    EXPECT_GE(rim.u, -0.5);
    EXPECT_GE(rim.v, -0.5);
    EXPECT_LE(rim.u, picture.width - 0.5);
    EXPECT_LE(rim.v, picture.height - 0.5);
  }
}

TEST(ShippedLensesTest, AllAreReadAndOverlapAllAround) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kConfigs / "lenses")) {
    SCOPED_TRACE(entry.path());
    const DualFisheyeCamera camera = read_lens_file(entry.path());
    const DualFisheyeLayout& layout = camera.layout;
    for (const FisheyeLens& lens : {layout.front, layout.back}) {
      EXPECT_GT(lens.largest_angle_rad, radians_from_degrees(94.0));
      EXPECT_LE(lens.centre.u, camera.picture.width);
    }
    EXPECT_LT((layout.front_position_m + layout.back_position_m).norm(), 1e-12)
        << "the origin is half way between the lenses";
    ++files;
  }
  EXPECT_EQ(files, 5);
}

// The starting values must be far enough from the truth to test a calibration, and as close as a
// user's would be.
TEST(ShippedLensesTest, RehearsalStartsSomePixelsFromTheTrueLenses) {
  const DualFisheyeCamera truth = read_lens_file(kConfigs / "lenses/simulated.yaml");
  const DualFisheyeCamera start = read_lens_file(kConfigs / "lenses/dual-fisheye.yaml");
  EXPECT_EQ(truth.picture, start.picture);
  for (const auto& [a, b] : {std::pair{truth.layout.front, start.layout.front},
                             std::pair{truth.layout.back, start.layout.back}}) {
    EXPECT_GT(largest_difference_px(a, b), 4.0);
    EXPECT_LT(largest_difference_px(a, b), 15.0);
    expect_inside(a, truth.picture);
  }
}

TEST(ShippedRehearsalTest, RigAndCaptureConfigurationsMatch) {
  const RigConfig rig = read_rig_config(kConfigs / "rehearsal-rig.yaml");
  const CaptureConfig capture = read_capture_config(kConfigs / "rehearsal-capture.yaml");
  EXPECT_TRUE(fs::equivalent(rig.capture_config, kConfigs / "rehearsal-capture.yaml"));
  EXPECT_EQ(capture.camera.frames, rig.camera.layout);
  EXPECT_EQ(capture.camera.width_px, rig.camera.width_px);
  EXPECT_EQ(capture.camera.height_px, rig.camera.width_px / 2);
  const PanoramaSize frame{capture.camera.width_px, capture.camera.height_px};
  EXPECT_TRUE(RigOptics(rig.camera, frame, rig.dolly, 1.0, 1).lenses());
  EXPECT_EQ(plan_capture(capture).lines.size(), 5U);
}

// Errors typical of rails placed by hand: lines up to 20 mm and 1.5 degrees off, stations by about
// as much. Offsets along the line do not count, as they do not affect the grid.
TEST(ShippedRehearsalTest, LinesHaveErrorsTypicalOfManualPlacement) {
  const RigConfig rig = read_rig_config(kConfigs / "rehearsal-rig.yaml");
  const CapturePlan plan = plan_capture(read_capture_config(kConfigs / "rehearsal-capture.yaml"));
  const Rail rail(rig.rail, plan, {rig.slider.low_switch_mm, rig.slider.high_switch_mm});
  double farthest_m = 0.0, most_turned_rad = 0.0;
  for (const CaptureLine& line : plan.lines) {
    for (const CaptureStation& station : line.stations) {
      const CameraPose pose = rail.carriage_pose(line.id, station.rail_mm, std::chrono::hours(1));
      const Eigen::Vector3d off_m =
          pose.position_m - Eigen::Vector3d(station.position_m.x_m, 0.0, station.position_m.z_m);
      const double across_m = line.axis == LineAxis::kX ? off_m.z() : off_m.x();
      farthest_m = std::max(farthest_m, std::hypot(across_m, off_m.y()));
      for (const double angle :
           {pose.attitude.yaw_rad, pose.attitude.pitch_rad, pose.attitude.roll_rad}) {
        most_turned_rad = std::max(most_turned_rad, std::abs(angle));
      }
    }
  }
  EXPECT_GT(farthest_m, 0.012);
  EXPECT_LT(farthest_m, 0.022);
  EXPECT_GT(degrees_from_radians(most_turned_rad), 0.8);
  EXPECT_LT(degrees_from_radians(most_turned_rad), 1.6);
}

}  // namespace
}  // namespace raywalk::simulator
