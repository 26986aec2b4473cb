#include "calibrate/grid/grid_result.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/grid/estimate_grid.h"
#include "calibrate/grid/test_grid.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

struct Estimated {
  TestGrid grid;
  GridResult result;

  explicit Estimated(const TestGridSettings& settings) : grid(TestGridMaker(settings, 3).make()) {
    result = estimate_from_matches(grid.set, GridMethod::kPoses, grid.solved,
                                   nominal_poses(grid.set), grid.crossings);
  }
  ordered_json document() const { return grid_document(grid.set, result); }
};

TEST(GridResultTest, DocumentHasLinesCrossingsAndPoses) {
  Estimated estimated({.stations = 11, .matches = 20});
  GridResult& result = estimated.result;
  result.crossings[1].before.rotation_px = 123.456;
  result.crossings[2].after.position_mm = 7.891;
  result.lines[1].height_mm = {3.21, 0.05};
  result.lines[1].position_models = {{.name = "straight"}, {.name = "bowed", .kept = true}};
  result.lines[0].rejected_frames = {4};
  result.notes = {"a note"};
  const ordered_json document = estimated.document();
  EXPECT_EQ(document["method"], "poses");
  EXPECT_EQ(document["stations"], 44);
  EXPECT_EQ(document["notes"][0], "a note");
  EXPECT_EQ(document["largest_disagreement"]["before"]["rotation_px"], 123.456);
  EXPECT_EQ(document["largest_disagreement"]["after"]["position_mm"], 7.891);
  EXPECT_EQ(document["lines"][0]["rejected"], ordered_json{estimated.grid.set.frames[4].name});
  EXPECT_EQ(document["lines"][1]["height_mm"]["sigma"], 0.05);
  EXPECT_EQ(document["lines"][1]["position_model"], "bowed");
  EXPECT_EQ(document["crossings"].size(), 4U);
  const ordered_json& frame = document["frames"][3];
  EXPECT_EQ(frame["planned_m"][0], estimated.grid.set.frames[3].nominal_m.x());
  EXPECT_EQ(frame["position_m"][0], result.poses[3]->position_m.x());
}

TEST(GridResultTest, WithoutCrossingsNothingDisagrees) {
  const Estimated estimated({.lines_x = 1, .lines_z = 0, .stations = 11});
  EXPECT_TRUE(estimated.document()["largest_disagreement"].is_null());
  EXPECT_TRUE(estimated.document()["crossings"].empty());
}

// What is small against the rest of a line is nothing that its rail has.
TEST(GridResultTest, DeviationsAreThoseOfTheStations) {
  Estimated estimated({.stations = 11, .jitter_mm = 0.01, .jitter_deg = 0.001, .matches = 20});
  FramePose& moved = *estimated.result.poses[4];
  moved.position_m.y() += 0.02;
  moved.world_from_camera =
      matrix_of({0.0, radians_from_degrees(1.0), 0.0}) * moved.world_from_camera;
  const auto document = grid_document(estimated.grid.set, estimated.result);
  const auto& line = document["deviations"][0];
  EXPECT_EQ(line["line"], "x0");
  ASSERT_EQ(line["stations"].size(), 11U);
  for (int i = 0; i < 11; ++i) {
    const auto& station = line["stations"][static_cast<size_t>(i)];
    EXPECT_EQ(station["name"], estimated.grid.set.frames[static_cast<size_t>(i)].name);
    EXPECT_NEAR(station["up_mm"], i == 4 ? 20.0 : 0.0, 0.5) << i;
    EXPECT_NEAR(station["along_mm"], 0.0, 0.5) << i;
    EXPECT_NEAR(station["about_y_deg"], i == 4 ? 1.0 : 0.0, 0.05) << i;
    EXPECT_NEAR(station["about_x_deg"], 0.0, 0.05) << i;
  }
}

TEST(LineSummaryTest, ParametersRoundTrip) {
  RailFrame frame{.axis = LineAxis::kZ, .middle_m = {1, 2, 3}, .half_length_m = 0.7};
  RailParameters parameters{};
  for (size_t i = 0; i < parameters.size(); ++i) {
    parameters[i] = 0.01 * static_cast<double>(i + 1);
  }
  LineFit line;
  describe_rail(frame, parameters,
                Eigen::Matrix<double, kRigidParameters, kRigidParameters>::Identity(), &line);
  const RailParameters back = rail_parameters(frame, line);
  for (size_t i = 0; i < parameters.size(); ++i) EXPECT_NEAR(back[i], parameters[i], 1e-12);
  EXPECT_NEAR(line.height_mm.value, 20.0, 1e-9);
  EXPECT_NEAR(line.across_mm.value, 10.0, 1e-9);  // +x of a line along z
  EXPECT_NEAR(line.along_mm.value, 30.0, 1e-9);
  EXPECT_NEAR(line.height_mm.sigma, 1000.0, 1e-9);
  // Heading rotates +z towards +x, tilt raises the end.
  EXPECT_NEAR(line.direction.x(), std::sin(0.04) * std::cos(0.05), 1e-12);
  EXPECT_NEAR(line.direction.y(), std::sin(0.05), 1e-12);
}

// Signs as in sphere.h: yaw rotates the centre towards +x, pitch raises it, roll rotates the camera
// clockwise.
TEST(LineSummaryTest, AttitudesHaveTheSignsOfTheWorld) {
  for (const Attitude& turned : {Attitude{0.1, 0, 0}, Attitude{0, 0.1, 0}, Attitude{0, 0, 0.1}}) {
    const Eigen::Vector3d vector = vector_of(world_from_camera(turned));
    RailParameters parameters{};
    std::copy_n(vector.data(), 3, parameters.begin() + RailParameter::kRotation);
    LineFit line;
    describe_rail({}, parameters, Eigen::Matrix<double, kRigidParameters, kRigidParameters>::Zero(),
                  &line);
    EXPECT_NEAR(line.yaw_deg.value, degrees_from_radians(turned.yaw_rad), 1e-9);
    EXPECT_NEAR(line.pitch_deg.value, degrees_from_radians(turned.pitch_rad), 1e-9);
    EXPECT_NEAR(line.roll_deg.value, degrees_from_radians(turned.roll_rad), 1e-9);
  }
}

}  // namespace
}  // namespace raywalk::calibrate
