#include "simulator/room/station_picture.h"

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core.hpp>

#include "core/panorama/srgb.h"
#include "simulator/room/camera_ring.h"
#include "simulator/room/sensor.h"
#include "simulator/room/test_rooms.h"

namespace raywalk::capture {
namespace {

constexpr PanoramaSize kStationSize{120, 60};

RoomStation station_at(double x_m) {
  RoomStation station;
  station.true_pose.position_m.x() = x_m;
  station.noise_key = 9;
  return station;
}

double linear_mean(const cv::Mat& image, int first, int last) {
  double sum = 0.0;
  for (int v = 0; v < image.rows; ++v) {
    for (int u = first; u < last; ++u) sum += linear_from_srgb_level(image.at<cv::Vec3b>(v, u)[1]);
  }
  return sum;
}

TEST(StationPictureTest, WithoutARingItIsTheSensorsPanorama) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  settings.sensor.noise_levels = 2.0;
  const VirtualRoom room(settings);
  const RoomStation station = station_at(0.3);
  const cv::Mat expected =
      apply_sensor(room.panorama(station.true_pose, kStationSize), settings.sensor, 1.0, 9);
  EXPECT_EQ(cv::norm(station_picture(room, station, 3, kStationSize), expected, cv::NORM_INF), 0.0);
}

TEST(StationPictureTest, RingWithEqualCamerasInOnePlaceChangesNothing) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  settings.ring.cameras = 4;
  settings.ring.feather_deg = 20.0;
  const VirtualRoom ring(settings), single(empty_room(4, 1.0));
  const RoomStation station = station_at(0.3);
  EXPECT_LE(cv::norm(station_picture(ring, station, 3, kStationSize),
                     station_picture(single, station, 3, kStationSize), cv::NORM_INF),
            1.0)
      << "rounding in the seams";
}

// Camera 1 of 4 sees the columns 75 to 104 of 120.
TEST(StationPictureTest, EachSectorHasTheExposureOfItsCameraAtTheStation) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  settings.light.exposure = 0.5;  // so that nothing clips
  const VirtualRoom single(settings);
  settings.ring.cameras = 4;
  settings.ring.station_gain_spread = 0.12;
  const VirtualRoom ring(settings);
  const RoomStation station = station_at(0.3);
  const cv::Mat plain = station_picture(single, station, 5, kStationSize);
  const cv::Mat exposed = station_picture(ring, station, 5, kStationSize);
  const std::vector<double> gains = ring_gains(settings.ring, settings.seed, 5);
  EXPECT_NEAR(linear_mean(exposed, 45, 75) / linear_mean(plain, 45, 75), gains[0], 0.005);
  EXPECT_NEAR(linear_mean(exposed, 75, 105) / linear_mean(plain, 75, 105), gains[1], 0.005);
  EXPECT_GT(std::abs(gains[0] - gains[1]), 0.02);
}

}  // namespace
}  // namespace raywalk::capture
