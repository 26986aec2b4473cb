#include "simulator/room/write_capture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/geometry/eye_circle.h"
#include "simulator/room/sensor.h"
#include "simulator/room/stations.h"
#include "simulator/room/truth.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

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
  // The station of that name: x0_002 is the third of the first line.
  static RoomStation station(const std::string& name) {
    for (const RoomStation& each : room_stations(room_->settings())) {
      if (each.name == name) return each;
    }
    throw Error("no station " + name);
  }
  void expect_distances(const std::string& name, const CameraPose& pose) const {
    const cv::Mat mm = read_distance_map(out_ / "dist" / (name + ".png"));
    const cv::Mat expected_m = room_->distance_map(pose, kSize);
    ASSERT_EQ(mm.size(), expected_m.size());
    for (int v = 0; v < mm.rows; ++v) {
      for (int u = 0; u < mm.cols; ++u) {
        const double metres = expected_m.at<float>(v, u);
        const double expected_mm = std::isinf(metres) ? 0.0 : 1e3 * metres;
        ASSERT_NEAR(mm.at<ushort>(v, u), expected_mm, 0.501) << name << " " << u << "," << v;
      }
    }
  }

  static std::unique_ptr<const VirtualRoom> room_;
  TestDirectory directory_;
  fs::path out_ = directory_ / "out";
};

std::unique_ptr<const VirtualRoom> WriteCaptureTest::room_;

TEST_F(WriteCaptureTest, FramesAreRenderedFromTheTruePosesWithSensorNoise) {
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
  }
}

TEST_F(WriteCaptureTest, DistanceMapsAreFromTheTruePosesInMillimetres) {
  write(1, 2);
  expect_distances("x0_002", station("x0_002").true_pose);
  expect_distances("z1_004", station("z1_004").true_pose);
  expect_distances("gt_centre", {});
  EXPECT_FALSE(fs::exists(out_ / "dist/x0_001.png")) << "every second station";
}

TEST_F(WriteCaptureTest, TruthIsExactAndFreeOfNoise) {
  write(2, 0);
  const CsvTable table = CsvTable::read(out_ / "gt.csv", {"file", "x", "y", "z", "distance"}, {});
  ASSERT_EQ(table.rows(), 2U);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const CameraPose pose{{table.number(row, "x"), table.number(row, "y"), table.number(row, "z")},
                          {}};
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
  const EyeCircle left{{table.number(0, "x"), table.number(0, "y"), table.number(0, "z")}, 0.04};
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
    EXPECT_NEAR(table.number(row, "x"), pose.position_m.x(), 1e-9);
    EXPECT_NEAR(table.number(row, "y"), pose.position_m.y(), 1e-9);
    EXPECT_NEAR(table.number(row, "z"), pose.position_m.z(), 1e-9);
  };
  for (std::size_t row = 0; row < stations.size(); ++row) {
    EXPECT_EQ(nominal.text(row, "file"), "capture/" + stations[row].name + ".png");
    EXPECT_EQ(actual.text(row, "file"), nominal.text(row, "file"));
    EXPECT_TRUE(fs::exists(out_ / nominal.text(row, "file")));
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

}  // namespace
}  // namespace raywalk::simulator
