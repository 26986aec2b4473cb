// The shipped configurations of the rehearsal, and the shipped lenses.
#include <gtest/gtest.h>

#include <cmath>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "core/files/lens_file.h"
#include "simulator/rig/rig_config.h"
#include "simulator/rig/rig_optics.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

namespace fs = std::filesystem;

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
