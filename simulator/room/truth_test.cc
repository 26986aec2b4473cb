#include "simulator/room/truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using ::testing::HasSubstr;

VirtualRoom room_with(const GridSettings& grid, int seed = 1, const std::string& more = "") {
  return {{.seed = seed, .grid = grid}, parse_scene("include: [empty]\n" + more, "a scene")};
}

TEST(TruthViewpointsTest, LieInsideTheCellsUnderUniqueNames) {
  const VirtualRoom room = room_with({.cell_side_m = 0.4, .cells_x = 3});
  const auto viewpoints = truth_viewpoints(room, 40);
  ASSERT_EQ(viewpoints.size(), 40U);
  std::set<std::string> names;
  for (const TruthViewpoint& viewpoint : viewpoints) {
    names.insert(viewpoint.name);
    EXPECT_LE(std::abs(viewpoint.position_m.x()), 0.6 + 1e-12);
    EXPECT_LE(std::abs(viewpoint.position_m.z()), 0.2 + 1e-12);
    EXPECT_EQ(viewpoint.position_m.y(), 0.0);
  }
  EXPECT_EQ(names.size(), viewpoints.size());
}

TEST(TruthViewpointsTest, CellsInWhichSomethingStandsArePassedOver) {
  constexpr const char* kColumn =
      "solids:\n  - {box: [-0.15, -1.3, -0.15, 0.15, 1.3, 0.15], at: [0.4, 0, 0], material: "
      "tiles}\n";
  const VirtualRoom room = room_with({.cell_side_m = 0.4, .cells_x = 3}, 1, kColumn);
  for (const TruthViewpoint& viewpoint : truth_viewpoints(room, 20)) {
    EXPECT_GT((viewpoint.position_m - Eigen::Vector3d(0.4, 0, 0)).norm(), 0.15) << viewpoint.name;
  }
  constexpr const char* kFull = "solids:\n  - {box: [-1, -1.3, -1, 1, 1.3, 1], material: tiles}\n";
  EXPECT_THROW(truth_viewpoints(room_with({}, 1, kFull), 1), Error);
}

TEST(TruthViewpointsTest, OneLiesOnAStationAndOneBetweenTwo) {
  for (int seed = 0; seed < 5; ++seed) {
    int on = 0, between = 0;
    for (const TruthViewpoint& viewpoint : truth_viewpoints(room_with({}, seed), 12)) {
      const double x_steps = viewpoint.position_m.x() * 40, z_steps = viewpoint.position_m.z() * 40;
      if (viewpoint.name == "line_left_on") {
        ++on;
        EXPECT_NEAR(viewpoint.position_m.x(), -0.5, 1e-12);
        EXPECT_NEAR(z_steps, std::round(z_steps), 1e-9);
      }
      if (viewpoint.name == "line_front_between") {
        ++between;
        EXPECT_NEAR(viewpoint.position_m.z(), 0.5, 1e-12);
        EXPECT_NEAR(std::abs(x_steps - std::round(x_steps)), 0.5, 1e-9);
      }
    }
    EXPECT_EQ(on, 1);
    EXPECT_EQ(between, 1);
  }
}

TEST(TruthViewpointsTest, AlongASingleLineTheyLieBetweenItsStations) {
  const auto viewpoints = truth_viewpoints(
      room_with({.cells_x = 0, .cells_z = 3, .spacing_mm = 1000.0, .overhang_share = 0.0}), 6);
  ASSERT_EQ(viewpoints.size(), 6U);
  for (std::size_t i = 0; i < viewpoints.size(); ++i) {
    const Eigen::Vector3d& at_m = viewpoints[i].position_m;
    EXPECT_LT(std::abs(at_m.z()), 1.5);
    EXPECT_EQ(at_m.x() == 0.0, i % 2 == 0) << viewpoints[i].name;
    EXPECT_LE(std::abs(at_m.x()), 0.1);
    const double from_station = std::remainder(at_m.z() - 0.5, 1.0);
    EXPECT_GT(std::abs(from_station), 0.25);
  }
}

TEST(TruthViewpointsTest, TableIsRead) {
  const TestDirectory directory;
  write_file_atomically(directory / "views.csv", "name,x,z,y\na,0.1,-0.2,0.05\nb,0,0,0\n");
  const auto viewpoints = read_truth_viewpoints(directory / "views.csv");
  ASSERT_EQ(viewpoints.size(), 2U);
  EXPECT_EQ(viewpoints[0].name, "a");
  EXPECT_EQ(viewpoints[0].position_m, Eigen::Vector3d(0.1, 0.05, -0.2));
}

TEST(TruthViewpointsTest, BadTablesAreRefusedByLine) {
  const TestDirectory directory;
  const auto expect_refused = [&](const std::string& text, const std::string& message) {
    write_file_atomically(directory / "views.csv", text);
    try {
      read_truth_viewpoints(directory / "views.csv");
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr(message));
    }
  };
  expect_refused("name,x,z\n", "no viewpoints");
  expect_refused("name,x,z\na,0,0\na,1,0\n", "views.csv:3");
  expect_refused("name,x,z\n../a,0,0\n", "is not a valid file name");
  expect_refused("name,x,z\na,0,one\n", "views.csv:2");
}

}  // namespace
}  // namespace raywalk::simulator
