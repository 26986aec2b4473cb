#include "simulator/room/write_capture.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <set>

#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "core/geometry/eye_circle.h"
#include "core/geometry/line_gaps.h"
#include "core/panorama/srgb.h"
#include "simulator/room/sensor.h"
#include "simulator/room/stations.h"
#include "simulator/room/truth.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr PanoramaSize kSize{64, 32};

// Five stations on each of four lines, with jitter.
VirtualRoomSettings settings() {
  VirtualRoomSettings settings;
  settings.grid.spacing_mm = 250.0;
  settings.grid.overhang_share = 0.0;
  settings.sensor = {.noise_levels = 2.0, .shot_noise = 0.05, .gain_spread = 0.1};
  settings.pose = {.position_jitter_mm = 4.0, .attitude_jitter_deg = 1.0};
  settings.output = {.width_px = kSize.width, .format = "png", .jpeg_quality = 95};
  return settings;
}

double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

Eigen::Vector3d position_in(const CsvTable& table, std::size_t row) {
  return {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")};
}

// Lighting a room takes a second, so all tests share one.
class WriteCaptureTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { room_ = std::make_unique<const VirtualRoom>(settings()); }
  static void TearDownTestSuite() { room_.reset(); }

  std::string write(int truth_views, int distance_every) const {
    return write_capture(
        *room_,
        {.out = out_, .views = {}, .truth_views = truth_views, .distance_every = distance_every});
  }
  // x0_002 is the third of the first line.
  static RoomStation station(const std::string& name) {
    const std::vector<RoomStation> stations = room_stations(room_->settings());
    return *std::ranges::find(stations, name, &RoomStation::name);
  }
  void expect_distances(const std::string& name, const CameraPose& pose) const {
    cv::Mat mm, expected_mm = 1e3 * room_->distance_map(pose, kSize);
    read_distance_map(out_ / "dist" / (name + ".png")).convertTo(mm, CV_32F);
    expected_mm.setTo(0.0, expected_mm == std::numeric_limits<float>::infinity());
    EXPECT_LE(largest_difference(mm, expected_mm), 0.501) << name;
  }

  static inline std::unique_ptr<const VirtualRoom> room_;
  TestDirectory directory_;
  fs::path out_ = directory_ / "out";
};

TEST_F(WriteCaptureTest, FramesWithSensorNoiseAndDistancesAreFromTheTruePoses) {
  EXPECT_THAT(write(1, 2), HasSubstr("20 panoramas of 64 x 32 on 4 lines, 1 true views, 13"));
  for (const char* name : {"x0_000", "x0_002", "z1_004"}) {
    const RoomStation seen = station(name);
    const cv::Mat frame = read_panorama(out_ / "capture" / (std::string(name) + ".png"));
    const cv::Mat panorama = room_->render(PanoramaRays(kSize), seen.true_pose);
    EXPECT_EQ(largest_difference(frame, apply_sensor(panorama, room_->settings().sensor, seen.gain,
                                                     seen.noise_key)),
              0.0)
        << name;
    EXPECT_GT(largest_difference(frame, panorama), 0.0) << "gain and noise show";
    expect_distances(name, seen.true_pose);
  }
  expect_distances("gt_centre", {});
  EXPECT_FALSE(fs::exists(out_ / "dist/x0_001.png")) << "every second station";
}

TEST_F(WriteCaptureTest, TruthIsExactAndFreeOfNoise) {
  write(2, 0);
  const CsvTable table = CsvTable::read(out_ / "gt.csv", {"file", "x", "y", "z", "distance"}, {});
  ASSERT_EQ(table.rows(), 2U);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const CameraPose pose{position_in(table, row), {}};
    EXPECT_EQ(largest_difference(read_panorama(out_ / table.text(row, "file")),
                                 room_->render(PanoramaRays(kSize), pose)),
              0.0)
        << table.text(row, "file");
    const fs::path distances = table.text(row, "distance");
    EXPECT_EQ(distances.parent_path(), "dist");
    expect_distances(distances.stem().string(), pose);
  }
}

TEST_F(WriteCaptureTest, ThinStructuresAreMaskedOnRequest) {
  write(2, 0);
  EXPECT_FALSE(fs::exists(out_ / "thin"));
  EXPECT_FALSE(fs::exists(out_ / "gt_thin.csv"));
  fs::remove_all(out_);
  write_capture(*room_,
                {.out = out_, .views = {}, .truth_views = 2, .distance_every = 0, .thin = true});
  const CsvTable table = CsvTable::read(out_ / "gt_thin.csv", {"file", "x", "y", "z", "mask"}, {});
  ASSERT_GT(table.rows(), 0U);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    EXPECT_TRUE(fs::exists(out_ / table.text(row, "mask"))) << "chairs have thin legs";
  }
}

// A column of an eye's true view is that of a camera in the eye's place.
TEST_F(WriteCaptureTest, StereoTruthIsSeenFromACircleOfEyes) {
  write_capture(*room_, {.out = out_, .truth_views = 1, .distance_every = 0, .ods_ipd_mm = 80.0});
  const cv::Mat both = read_picture(out_ / "ods/centre.png");
  ASSERT_EQ(both.size(), cv::Size(kSize.width, kSize.width));
  const CsvTable table = CsvTable::read(out_ / "gt.csv", {"file", "x", "y", "z", "distance"}, {});
  const EyeCircle left{position_in(table, 0), 0.04};
  for (const EyeCircle& eye : {left, left.opposite()}) {
    const int first_row = eye.radius_m > 0.0 ? 0 : kSize.height;
    for (const int u : {0, 10, 40}) {
      const double theta = angles_from_pixel({double(u), 0.0}, kSize).theta_rad;
      const cv::Mat there = room_->render(PanoramaRays(kSize), {eye.position_m(theta), {}});
      const cv::Mat column = both.rowRange(first_row, first_row + kSize.height).col(u);
      EXPECT_LT(cv::norm(column, there.col(u), cv::NORM_L1) / (3.0 * kSize.height), 0.5) << u;
    }
  }
}

TEST_F(WriteCaptureTest, TablesHoldNominalAndTruePoses) {
  write(0, 0);
  const std::vector<RoomStation> stations = room_stations(room_->settings());
  const CsvTable nominal = CsvTable::read(out_ / "poses.csv", {"file", "x", "y", "z", "line"}, {});
  const CsvTable actual =
      CsvTable::read(out_ / "true_poses.csv", {"file", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  ASSERT_EQ(nominal.rows(), stations.size());
  ASSERT_EQ(actual.rows(), stations.size());
  const auto expect_position = [](const CsvTable& table, std::size_t row, const CameraPose& pose) {
    EXPECT_LT((position_in(table, row) - pose.position_m).norm(), 2e-9);
  };
  for (std::size_t row = 0; row < stations.size(); ++row) {
    EXPECT_EQ(nominal.text(row, "file"), "capture/" + stations[row].name + ".png");
    EXPECT_EQ(actual.text(row, "file"), nominal.text(row, "file"));
    expect_position(nominal, row, stations[row].nominal);
    expect_position(actual, row, stations[row].true_pose);
    const Attitude& attitude = stations[row].true_pose.attitude;
    EXPECT_NEAR(actual.number(row, "yaw"), degrees_from_radians(attitude.yaw_rad), 1e-9);
    EXPECT_NEAR(actual.number(row, "pitch"), degrees_from_radians(attitude.pitch_rad), 1e-9);
    EXPECT_NEAR(actual.number(row, "roll"), degrees_from_radians(attitude.roll_rad), 1e-9);
  }
}

// 360 columns of one degree; a wall at 3 m.
cv::Mat wall() { return cv::Mat(180, 360, CV_32FC1, cv::Scalar(3.0)); }

TEST(ThinStructuresTest, PostsAreThinAndCabinetsAreNot) {
  cv::Mat map = wall();
  map.colRange(100, 102).rowRange(60, 120).setTo(1.5);  // a post
  map.rowRange(90, 91).colRange(200, 260).setTo(1.5);   // a rail
  map.colRange(20, 60).rowRange(60, 120).setTo(1.5);    // a cabinet
  const cv::Mat thin = thin_structures(map);
  EXPECT_EQ(cv::countNonZero(thin(cv::Rect(99, 60, 4, 60))), 4 * 60) << "with a pixel around";
  EXPECT_EQ(cv::countNonZero(thin(cv::Rect(200, 89, 60, 3))), 3 * 60);
  EXPECT_EQ(cv::countNonZero(thin), 4 * 62 + 3 * 62);
}

TEST(ThinStructuresTest, PostsBeforeTheSkyAndAcrossTheSeamAreFound) {
  cv::Mat map = wall();
  map.rowRange(0, 90).setTo(std::numeric_limits<float>::infinity());
  map.colRange(0, 1).setTo(2.0);
  map.colRange(359, 360).setTo(2.0);
  const cv::Mat thin = thin_structures(map);
  EXPECT_EQ(thin.at<uchar>(40, 0), 255);
  EXPECT_EQ(thin.at<uchar>(130, 359), 255);
  EXPECT_EQ(thin.at<uchar>(40, 5), 0);
}

TEST(ThinStructuresTest, SlopesAreNotThin) {
  cv::Mat map = wall();
  for (int v = 100; v < 180; ++v) map.row(v).setTo(3.0 / (1.0 + 0.05 * (v - 100)));
  EXPECT_EQ(cv::countNonZero(thin_structures(map)), 0);
}

// --- The sensor ----------------------------------------------------------------------------------

cv::Mat grey(int level) { return cv::Mat(200, 300, CV_8UC3, cv::Scalar::all(level)); }

TEST(SensorTest, PerfectSensorChangesNothing) {
  for (int level = 0; level < 256; ++level) {
    EXPECT_EQ(largest_difference(apply_sensor(grey(level), {}, 1.0, 1), grey(level)), 0.0) << level;
  }
}

// The standard error of the mean of 180,000 values is 0.24 % of their deviation, that of the
// deviation 0.17 %.
// Shot noise grows with the square root of brightness.
TEST(SensorTest, NoiseHasTheGivenMeanAndDeviation) {
  struct Case {
    double noise_levels, shot_noise;
    int level;
  };
  for (const Case& each :
       {Case{1.0, 0.0, 120}, {3.0, 0.0, 120}, {8.0, 0.0, 120}, {1.0, 0.2, 40}, {1.0, 0.2, 160}}) {
    const SensorSettings sensor{.noise_levels = each.noise_levels, .shot_noise = each.shot_noise};
    const double variance = each.noise_levels * each.noise_levels + each.shot_noise * each.level;
    cv::Scalar mean, deviation;
    cv::meanStdDev(apply_sensor(grey(each.level), sensor, 1.0, 5).reshape(1), mean, deviation);
    EXPECT_NEAR(mean[0], each.level, 0.012 * std::sqrt(variance));
    // Rounding to whole levels adds a variance of 1/12.
    EXPECT_NEAR(deviation[0], std::sqrt(variance + 1.0 / 12.0), 0.01 * std::sqrt(variance));
  }
}

TEST(SensorTest, ChannelsAndNeighboursAreIndependent) {
  cv::Mat noise;
  apply_sensor(grey(128), {.noise_levels = 6.0}, 1.0, 7).convertTo(noise, CV_32F);
  noise -= cv::Scalar::all(128.0);
  const cv::Mat values = noise.reshape(1);
  const double variance = values.dot(values) / static_cast<double>(values.total());
  for (const int step : {1, 2, 3, 6}) {  // within a pixel, across channels, neighbouring pixels
    const cv::Mat a = values.colRange(0, values.cols - step);
    const cv::Mat b = values.colRange(step, values.cols);
    EXPECT_NEAR(a.dot(b) / static_cast<double>(a.total()) / variance, 0.0, 0.015) << step;
  }
}

// Else the same noise in every frame would look like texture of the scene.
TEST(SensorTest, KeyChoosesTheNoise) {
  const auto noisy = [](int key) {
    return apply_sensor(grey(90), {.noise_levels = 4.0}, 1.0, key);
  };
  EXPECT_EQ(largest_difference(noisy(1), noisy(1)), 0.0);
  EXPECT_GT(cv::norm(noisy(1), noisy(2), cv::NORM_L2) / std::sqrt(noisy(1).total() * 3.0), 4.0);
}

TEST(SensorTest, GainMultipliesLightAndClipsAtWhite) {
  for (const int level : {20, 100, 150}) {
    EXPECT_NEAR(cv::mean(apply_sensor(grey(level), {}, 1.5, 1))[0],
                srgb_level_from_linear(1.5 * linear_from_srgb_level(level)), 0.5);
  }
  EXPECT_EQ(cv::mean(apply_sensor(grey(240), {}, 2.0, 1))[0], 255.0);
}

TEST(SensorTest, RefusesOtherImagesGainsAndLight) {
  EXPECT_THROW(apply_sensor(cv::Mat(4, 4, CV_8UC1), {}, 1.0, 1), Error);
  EXPECT_THROW(apply_sensor(grey(1), {}, 0.0, 1), Error);
  EXPECT_THROW(apply_sensor(grey(1), {}, std::nan(""), 1), Error);
  EXPECT_THROW(apply_sensor(grey(1), {}, 1.0, 1, cv::Mat(4, 4, CV_32FC1)), Error);
}

TEST(ToneTest, CurveRisesAndBendsAtHighlights) {
  EXPECT_EQ(level_from_light(-1.0F), 0.0F);
  EXPECT_NEAR(level_from_light(0.5F), 187.5F, 0.1F);  // sRGB's level of a half
  for (int i = 1; i <= 400; ++i) {
    EXPECT_GE(level_from_light(0.01F * static_cast<float>(i)),
              level_from_light(0.01F * static_cast<float>(i - 1)));
  }
  EXPECT_LT(level_from_light(1.0F), 250.0F);
  EXPECT_NEAR(level_from_light(100.0F), 255.0F, 0.5F);
}

// --- Stations ------------------------------------------------------------------------------------

// The detection of lines and cells used for rooms finds the planned ones, with the same names.
TEST(PlanLinesTest, PlannedGridIsDetected) {
  const GridSettings settings{.cell_side_m = 0.6, .cells_x = 3, .cells_z = 2, .spacing_mm = 100.0};
  const std::vector<PlannedLine> lines = plan_lines(settings);
  std::vector<StationPose> stations;
  for (const PlannedLine& line : lines) {
    for (const double along_m : line.along_m) {
      stations.push_back({line.id, line.position_m(along_m), ""});
    }
  }
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), lines.size());
  EXPECT_EQ(grid.cells.size(), 6U);
  for (std::size_t i = 0; i < grid.lines.size(); ++i) {
    EXPECT_EQ(grid.lines[i].id, lines[i].id);
    EXPECT_EQ(grid.lines[i].stations.front().file, lines[i].id);
    EXPECT_NEAR(median_spacing_m(grid.lines[i]), 0.1, 1e-12);
  }
  // 25 % of 6 steps, rounded down: one step at each end.
  EXPECT_NEAR(lines[0].along_m.front(), -0.9 - 0.1, 1e-12);
}

TEST(PlanLinesTest, SpacingIsRoundedToWholeStepsAndDefaultsToAFortieth) {
  GridSettings grid;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 61U);
  grid.spacing_mm = 300.0;  // a cell of 1 m takes 3 steps
  grid.overhang_share = 0.0;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 4U);
  grid.spacing_mm = 5000.0;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 2U);
  grid.spacing_mm = 0.1;
  EXPECT_THROW(plan_lines(grid), UsageError);
}

TEST(PlanLinesTest, LinesMayShareTheirIntersectionsOrBeASingleOne) {
  GridSettings grid{.spacing_mm = 250.0, .overhang_share = 0.0, .shared_intersections = true};
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 5U);
  EXPECT_EQ(plan_lines(grid)[2].along_m.size(), 3U);
  grid.cells_x = 0;
  grid.cells_z = 4;
  const std::vector<PlannedLine> lines = plan_lines(grid);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].along_m.size(), 17U);
  EXPECT_EQ(lines[0].position_m(lines[0].along_m[0]), Eigen::Vector3d(0, 0, -2));
}

TEST(RoomStationsTest, StationsLieOnTheGridUnderUniqueNames) {
  VirtualRoomSettings settings;
  settings.grid.cell_side_m = 2.0;
  settings.grid.spacing_mm = 500.0;
  const auto stations = room_stations(settings);
  ASSERT_EQ(stations.size(), 4U * 7U);
  std::set<std::string> names;
  for (const RoomStation& station : stations) {
    names.insert(station.name);
    EXPECT_EQ(station.nominal.position_m.y(), 0.0);
    EXPECT_EQ(station.true_pose.position_m, station.nominal.position_m);
    EXPECT_EQ(station.true_pose.attitude.yaw_rad, 0.0);
    EXPECT_EQ(station.gain, 1.0);
  }
  EXPECT_EQ(names.size(), stations.size());
  // The back line starts at its left overhang.
  EXPECT_EQ(stations[0].name, "x0_000");
  EXPECT_EQ(stations[0].nominal.position_m, Eigen::Vector3d(-1.5, 0, -1.0));
  EXPECT_EQ(stations[6].number, 6);
}

TEST(RoomStationsTest, JitterAndGainHaveTheGivenDeviation) {
  VirtualRoomSettings settings;
  settings.grid.cells_x = settings.grid.cells_z = 4;
  settings.grid.spacing_mm = 5.0;
  settings.pose = {2.0, 0.1};
  settings.sensor.gain_spread = 0.05;
  const auto stations = room_stations(settings);
  ASSERT_GT(stations.size(), 5000U);
  double position = 0.0, attitude = 0.0, gain = 0.0, mean_gain = 0.0;
  const auto count = static_cast<double>(stations.size());
  for (const RoomStation& station : stations) {
    position +=
        (station.true_pose.position_m - station.nominal.position_m).squaredNorm() / 3.0 / count;
    const auto& [yaw, pitch, roll] = station.true_pose.attitude;
    attitude += (yaw * yaw + pitch * pitch + roll * roll) / 3.0 / count;
    gain += (station.gain - 1.0) * (station.gain - 1.0) / count;
    mean_gain += station.gain / count;
  }
  EXPECT_NEAR(std::sqrt(position), 0.002, 0.00005);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(attitude)), 0.1, 0.0025);
  EXPECT_NEAR(std::sqrt(gain), 0.05, 0.002);
  EXPECT_NEAR(mean_gain, 1.0, 0.003);
}

// --- True views ----------------------------------------------------------------------------------

VirtualRoom room_around(const GridSettings& grid, int seed = 1, const std::string& more = "") {
  return {{.seed = seed, .grid = grid}, parse_scene("include: [empty]\n" + more, "a scene")};
}

TEST(TruthViewpointsTest, LieInsideTheCellsUnderUniqueNames) {
  const VirtualRoom room = room_around({.cell_side_m = 0.4, .cells_x = 3});
  std::set<std::string> names;
  for (const TruthViewpoint& viewpoint : truth_viewpoints(room, 40)) {
    names.insert(viewpoint.name);
    EXPECT_LE(std::abs(viewpoint.position_m.x()), 0.6 + 1e-12);
    EXPECT_LE(std::abs(viewpoint.position_m.z()), 0.2 + 1e-12);
    EXPECT_EQ(viewpoint.position_m.y(), 0.0);
  }
  EXPECT_EQ(names.size(), 40U);
}

TEST(TruthViewpointsTest, CellsInWhichSomethingStandsArePassedOver) {
  constexpr const char* kColumn =
      "solids:\n  - {box: [-0.15, -1.3, -0.15, 0.15, 1.3, 0.15], at: [0.4, 0, 0], material: "
      "tiles}\n";
  const VirtualRoom room = room_around({.cell_side_m = 0.4, .cells_x = 3}, 1, kColumn);
  for (const TruthViewpoint& viewpoint : truth_viewpoints(room, 20)) {
    EXPECT_GT((viewpoint.position_m - Eigen::Vector3d(0.4, 0, 0)).norm(), 0.15) << viewpoint.name;
  }
  constexpr const char* kFull = "solids:\n  - {box: [-1, -1.3, -1, 1, 1.3, 1], material: tiles}\n";
  EXPECT_THROW(truth_viewpoints(room_around({}, 1, kFull), 1), Error);
}

TEST(TruthViewpointsTest, OneLiesOnAStationAndOneBetweenTwo) {
  for (int seed = 0; seed < 5; ++seed) {
    std::map<std::string, Eigen::Vector3d> at_m;
    for (const TruthViewpoint& viewpoint : truth_viewpoints(room_around({}, seed), 12)) {
      at_m[viewpoint.name] = viewpoint.position_m;
    }
    // Stations are a fortieth of a metre apart.
    const Eigen::Vector3d on = 40.0 * at_m.at("line_left_on");
    const Eigen::Vector3d between = 40.0 * at_m.at("line_front_between");
    EXPECT_NEAR(on.x(), -20.0, 1e-9);
    EXPECT_NEAR(std::remainder(on.z(), 1.0), 0.0, 1e-9);
    EXPECT_NEAR(between.z(), 20.0, 1e-9);
    EXPECT_NEAR(std::abs(std::remainder(between.x(), 1.0)), 0.5, 1e-9);
  }
}

TEST(TruthViewpointsTest, AlongASingleLineTheyLieBetweenItsStations) {
  const auto viewpoints = truth_viewpoints(
      room_around({.cells_x = 0, .cells_z = 3, .spacing_mm = 1000.0, .overhang_share = 0.0}), 6);
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
    EXPECT_THAT(error_of([&] { read_truth_viewpoints(directory / "views.csv"); }),
                HasSubstr(message));
  };
  expect_refused("name,x,z\n", "no viewpoints");
  expect_refused("name,x,z\na,0,0\na,1,0\n", "views.csv:3");
  expect_refused("name,x,z\n../a,0,0\n", "is not a valid file name");
  expect_refused("name,x,z\na,0,one\n", "views.csv:2");
}

}  // namespace
}  // namespace raywalk::simulator
