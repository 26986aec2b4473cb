#include "simulator/rig/rail.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

constexpr Duration kLong = std::chrono::hours(1);

// Two lines of 1 m through the origin, stations at 100 to 1100 mm on the rail.
CapturePlan cross_plan() {
  CapturePlan plan;
  for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
    CaptureLine line{axis == LineAxis::kX ? "x0" : "z0", axis, 0.0, false, {}};
    for (int i = 0; i <= 10; ++i) {
      const double along_m = -0.5 + 0.1 * i;
      CaptureStation station;
      station.position_m = axis == LineAxis::kX ? PlanPoint{along_m, 0.0} : PlanPoint{0.0, along_m};
      station.rail_mm = 100.0 + 100.0 * i;
      line.stations.push_back(station);
    }
    plan.lines.push_back(line);
  }
  return plan;
}

RailSettings perfect() {
  RailSettings settings;
  settings.placing_spread_mm = settings.direction_spread_deg = settings.tilt_spread_deg = 0.0;
  settings.sag_mm = settings.bow_mm = settings.attitude_spread_deg = settings.vibration_mm = 0.0;
  return settings;
}

constexpr RailSpan kSpan{0.0, 1200.0};

TEST(RailTest, PerfectRailReachesThePlannedStations) {
  const CapturePlan plan = cross_plan();
  const Rail rail(perfect(), plan, kSpan);
  for (const CaptureLine& line : plan.lines) {
    for (const CaptureStation& station : line.stations) {
      const CameraPose pose = rail.carriage_pose(line.id, station.rail_mm, kLong);
      EXPECT_NEAR(pose.position_m.x(), station.position_m.x_m, 1e-12);
      EXPECT_NEAR(pose.position_m.y(), 0.0, 1e-12);
      EXPECT_NEAR(pose.position_m.z(), station.position_m.z_m, 1e-12);
      EXPECT_EQ(pose.attitude.yaw_rad, 0.0);
    }
  }
}

TEST(RailTest, SagsBetweenItsSupportsAndBowsToTheLeft) {
  RailSettings settings = perfect();
  settings.sag_mm = 2.0;
  settings.bow_mm = 1.0;
  const Rail rail(settings, cross_plan(), kSpan);
  const auto at = [&](const char* line, double mm) {
    return rail.carriage_pose(line, mm, kLong).position_m;
  };
  EXPECT_NEAR(at("x0", 0.0).y(), 0.0, 1e-12);
  EXPECT_NEAR(at("x0", 600.0).y(), -0.002, 1e-12);
  EXPECT_NEAR(at("x0", 300.0).y(), -0.0015, 1e-12) << "(1 - 0.5^2) of it at a quarter of the span";
  EXPECT_NEAR(at("x0", 600.0).z(), 0.001, 1e-12);
  EXPECT_NEAR(at("z0", 600.0).x(), -0.001, 1e-12);
}

// Along x the camera's right side points along the rail, along z its front does.
TEST(RailTest, CameraTurnsWithTheRail) {
  RailSettings settings = perfect();
  settings.direction_spread_deg = settings.tilt_spread_deg = 1.0;
  settings.sag_mm = 4.0;
  settings.bow_mm = 3.0;
  const Rail rail(settings, cross_plan(), kSpan);
  for (const double mm : {50.0, 300.0, 600.0, 1100.0}) {
    for (const std::string line : {"x0", "z0"}) {
      const CameraPose pose = rail.carriage_pose(line, mm, kLong);
      const Eigen::Vector3d tangent = (rail.carriage_pose(line, mm + 0.01, kLong).position_m -
                                       rail.carriage_pose(line, mm - 0.01, kLong).position_m)
                                          .normalized();
      const Eigen::Vector3d own =
          line == "x0" ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
      EXPECT_LT((world_from_camera(pose.attitude) * own - tangent).norm(), 2e-5) << line << mm;
    }
  }
}

TEST(RailTest, PlacingsHaveTheGivenSpreadAndAreRepeatable) {
  RailSettings settings = perfect();
  settings.placing_spread_mm = 3.0;
  settings.attitude_spread_deg = 0.5;
  const CapturePlan plan = cross_plan();
  double position = 0.0, yaw = 0.0;
  constexpr int kSeeds = 1000;
  for (settings.seed = 1; settings.seed <= kSeeds; ++settings.seed) {
    const CameraPose pose = Rail(settings, plan, kSpan).carriage_pose("z0", 600.0, kLong);
    position += pose.position_m.squaredNorm() / 3.0 / kSeeds;
    yaw += pose.attitude.yaw_rad * pose.attitude.yaw_rad / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(position), 0.003, 0.0002);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(yaw)), 0.5, 0.05);
  settings.seed = 7;
  const Rail rail(settings, plan, kSpan), again(settings, plan, kSpan);
  EXPECT_EQ(rail.carriage_pose("x0", 600.0, kLong).position_m,
            again.carriage_pose("x0", 600.0, kLong).position_m);
  EXPECT_NE(rail.carriage_pose("x0", 600.0, kLong).position_m,
            rail.carriage_pose("z0", 600.0, kLong).position_m);
}

// The ends are turned by half the twist, in opposite directions.
TEST(RailTest, TwistTurnsTheCameraAroundTheRail) {
  RailSettings settings = perfect();
  settings.twist_deg = 2.0;
  const Rail rail(settings, cross_plan(), kSpan);
  for (const double share : {-1.0, -0.5, 0.0, 1.0}) {
    for (const std::string line : {"x0", "z0"}) {
      const CameraPose pose = rail.carriage_pose(line, 600.0 + 600.0 * share, kLong);
      // Clockwise along x takes the top to the back, along z to the right.
      const Eigen::Vector3d up = world_from_camera(pose.attitude) * Eigen::Vector3d::UnitY();
      const double turned_rad = radians_from_degrees(share);
      const Eigen::Vector3d expected =
          line == "x0" ? Eigen::Vector3d(0, std::cos(turned_rad), -std::sin(turned_rad))
                       : Eigen::Vector3d(std::sin(turned_rad), std::cos(turned_rad), 0);
      EXPECT_LT((up - expected).norm(), 1e-12) << line << share;
    }
  }
}

TEST(RailTest, JitterHasTheGivenSpreadAndIsFixedPerStation) {
  RailSettings settings = perfect();
  settings.jitter_mm = 0.7;
  settings.jitter_deg = 0.1;
  double squared_m2 = 0.0, squared_rad2 = 0.0;
  int stations = 0;
  for (settings.seed = 1; settings.seed <= 100; ++settings.seed) {
    const CapturePlan plan = cross_plan();
    const Rail rail(settings, plan, kSpan);
    for (const CaptureLine& line : plan.lines) {
      for (const CaptureStation& station : line.stations) {
        const CameraPose pose = rail.carriage_pose(line.id, station.rail_mm, kLong);
        const Eigen::Vector3d planned_m(station.position_m.x_m, 0.0, station.position_m.z_m);
        squared_m2 += (pose.position_m - planned_m).squaredNorm();
        const Attitude& turned = pose.attitude;
        squared_rad2 += turned.yaw_rad * turned.yaw_rad + turned.pitch_rad * turned.pitch_rad +
                        turned.roll_rad * turned.roll_rad;
        ++stations;
        // A second picture, offset by the backlash, has the same jitter.
        const CameraPose again = rail.carriage_pose(line.id, station.rail_mm + 0.02, kLong);
        EXPECT_NEAR((again.position_m - pose.position_m).norm(), 2e-5, 1e-12);
        EXPECT_EQ(again.attitude.yaw_rad, turned.yaw_rad);
      }
    }
  }
  // 6,600 deviates: their spread is known to 0.9 %.
  EXPECT_NEAR(std::sqrt(squared_m2 / (3 * stations)), 7e-4, 2.5e-5);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(squared_rad2 / (3 * stations))), 0.1, 3.5e-3);
}

TEST(RailTest, VibrationDecays) {
  RailSettings settings = perfect();
  settings.vibration_mm = 1.0;
  settings.vibration_decay_ms = 100.0;
  const Rail rail(settings, cross_plan(), kSpan);
  double largest_at_once = 0.0;
  for (int i = 0; i <= 10; ++i) {
    const double mm = 100.0 + 100.0 * i;
    const Eigen::Vector3d rest_m = rail.carriage_pose("x0", mm, kLong).position_m;
    const auto off_mm = [&](std::optional<Duration> still_for) {
      return 1e3 * (rail.carriage_pose("x0", mm, still_for).position_m - rest_m).norm();
    };
    largest_at_once = std::max(largest_at_once, off_mm(Duration::zero()));
    EXPECT_LE(off_mm(duration_from_ms(300.0)), std::sqrt(2.0) * std::exp(-3.0));
    EXPECT_LT(off_mm(duration_from_ms(1500.0)), 1e-5);
    EXPECT_EQ(off_mm(std::nullopt), off_mm(Duration::zero()));
  }
  EXPECT_GT(largest_at_once, 0.7);
}

TEST(RailTest, UnknownLineAndEmptySpanAreErrors) {
  const Rail rail(perfect(), cross_plan(), kSpan);
  EXPECT_TRUE(rail.has_line("x0"));
  EXPECT_FALSE(rail.has_line("x1"));
  EXPECT_THROW(rail.carriage_pose("x1", 0.0, kLong), Error);
  EXPECT_THROW(Rail(perfect(), cross_plan(), {5.0, 5.0}), Error);
}

}  // namespace
}  // namespace raywalk::simulator
