#include "calibrate/grid/grid_result.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "calibrate/grid/grid_estimation.h"
#include "calibrate/grid/line_summary.h"
#include "calibrate/grid/test_grid.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

struct Written {
  TestDirectory directory;
  TestGrid grid = TestGridMaker({.stations = 11, .bow_mm = 5.0, .matches = 20}, 3).make();
  GridResult result;
  std::filesystem::path file = directory / "grid.json";

  Written() {
    grid.solved[4]->position_m.y() += 0.1;
    result = estimate_from_matches(grid.set, GridMethod::kPoses, grid.solved,
                                   nominal_poses(grid.set), grid.crossings);
    result.notes.push_back("a note");
    write_file_atomically(file, json_text(grid_document(grid.set, result)));
  }

  std::string error_of(const std::string& text) const {
    write_file_atomically(file, text);
    try {
      read_grid_result(file, grid.set);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }
};

TEST(GridResultTest, ReadsWhatItWrote) {
  const Written written;
  const GridResult read = read_grid_result(written.file, written.grid.set);
  // Writing what was read gives the same values, so nothing was lost.
  const json one = json::parse(read_file(written.file));
  const json two = json::parse(json_text(grid_document(written.grid.set, read)));
  // Attitudes are converted between angles and matrices, which rounds the last digits.
  EXPECT_EQ(one.at("lines"), two.at("lines"));
  EXPECT_EQ(one.at("crossings"), two.at("crossings"));
  EXPECT_EQ(one.at("notes"), two.at("notes"));
  ASSERT_EQ(read.poses.size(), written.result.poses.size());
  for (size_t i = 0; i < read.poses.size(); ++i) {
    ASSERT_TRUE(read.poses[i]);
    EXPECT_EQ(read.poses[i]->position_m, written.result.poses[i]->position_m);
    EXPECT_LT(
        angle_between(read.poses[i]->world_from_camera, written.result.poses[i]->world_from_camera),
        1e-9);
  }
  EXPECT_EQ(read.lines[0].rejected_frames, written.result.lines[0].rejected_frames);
  EXPECT_THAT(read.lines[0].rejected_frames, Contains(4));
}

TEST(GridResultTest, DamagedFilesAreNamed) {
  const Written written;
  const json root = json::parse(read_file(written.file));
  EXPECT_THAT(written.error_of("{"), AllOf(HasSubstr("grid.json"), HasSubstr("again")));
  json newer = root;
  newer["format_version"] = 99;
  EXPECT_THAT(written.error_of(newer.dump()), HasSubstr("grid.json"));
  json foreign = root;
  foreign["lines"][0]["id"] = "q7";
  EXPECT_THAT(written.error_of(foreign.dump()), HasSubstr("'q7'"));
  json short_list = root;
  short_list["lines"][0]["direction"] = {1.0, 0.0};
  EXPECT_THAT(written.error_of(short_list.dump()), HasSubstr("grid.json"));
  json missing = root;
  missing["crossings"][0].erase("after");
  EXPECT_THAT(written.error_of(missing.dump()), HasSubstr("after"));
  json unposed = root;
  unposed["frames"].erase(0);
  EXPECT_THAT(written.error_of(unposed.dump()), HasSubstr("'x0_000' has no pose"));
  std::filesystem::remove(written.file);
  EXPECT_THROW(read_grid_result(written.file, written.grid.set), Error);
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
