#include "render/web/station_pictures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/files/atomic_output.h"
#include "core/room/gain_fields.h"
#include "core/view/test_room.h"
#include "render/web/station_distances.h"

namespace raywalk::render {
namespace {

constexpr double kConeDeg = 22.0;

CameraCompanion dolly(bool masked) {
  return {.hides =
              [](const std::string&, int, const Eigen::Vector3d& direction) {
                return -direction.y() > std::cos(radians_from_degrees(kConeDeg));
              },
          .masked = masked};
}

// In front of every fourth station.
CameraCompanion visitor() {
  return {.hides =
              [](const std::string&, int station, const Eigen::Vector3d& direction) {
                return station % 4 == 1 && direction.x() > 0.9;
              },
          .masked = false,
          .left_out = true};
}

cv::Mat picture_of(const Room& room, int line, int station, int width) {
  StationDistances distances(room, width / 2);
  StationPictures pictures(room, {.method = ViewMethod::kTwoSided, .width = width});
  return pictures.picture_of(line, station, distances.seen_from(line, station));
}

cv::Mat truth_at(const TestRoom& room, int line, int station, int width) {
  const Eigen::Vector3d& at_m = room.room().grid().station({line, station}).position_m;
  return room.truth({at_m.x(), at_m.z()}, width);
}

cv::Mat averaged(const cv::Mat& picture, int width) {
  cv::Mat smaller;
  cv::resize(picture, smaller, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  return smaller;
}

// Pixels of the companions' magenta, which no wall has.
int companion_pixels(const cv::Mat& picture) {
  cv::Mat found;
  cv::inRange(picture, cv::Scalar(230, 0, 230), cv::Scalar(255, 25, 255), found);
  return cv::countNonZero(found);
}

cv::Mat lowest_rows(const cv::Mat& picture) {
  return picture.rowRange(picture.rows * 7 / 8, picture.rows).clone();
}

TEST(StationPictures, AreTheCapturedOnesWhereAllIsShown) {
  const TestRoom room(box_room(96));
  EXPECT_EQ(largest_difference(picture_of(room.room(), 0, 6, 96), truth_at(room, 0, 6, 96)), 0.0);
  EXPECT_EQ(
      largest_difference(picture_of(room.room(), 0, 6, 48), averaged(truth_at(room, 0, 6, 96), 48)),
      0.0);
  EXPECT_TRUE(hidden_in_views(room.room(), 0, 6, 96).empty());
}

TEST(StationPictures, MaskedOnesAreCompletedFromOtherStations) {
  SyntheticRoomSpec spec = box_room(192);
  spec.companion = dolly(false);
  const TestRoom shown(spec);
  ASSERT_GT(companion_pixels(picture_of(shown.room(), 0, 6, 192)), 1000);
  spec.companion = dolly(true);
  const TestRoom room(spec);
  // In the middle of a line, at a corner, and beyond the cells, where no view can be rendered.
  for (const int station : {6, 10, 0, 12}) {
    const cv::Mat picture = picture_of(room.room(), 0, station, 192);
    EXPECT_EQ(companion_pixels(picture), 0) << station;
    const cv::Mat truth = truth_at(room, 0, station, 192);
    EXPECT_GT(psnr_db(lowest_rows(picture), lowest_rows(truth)), 26.0) << station;
    const cv::Rect above(0, 0, 192, 80);
    EXPECT_EQ(largest_difference(picture(above).clone(), truth(above).clone()), 0.0);
  }
}

TEST(StationPictures, WhatViewsLeaveOutIsCompletedToo) {
  SyntheticRoomSpec spec = box_room(96);
  spec.companion = visitor();
  const TestRoom room(spec);
  ASSERT_GT(companion_pixels(captured_picture_at(room.room(), 0, 5, 96)), 100);
  for (const int width : {96, 64}) {
    const cv::Mat picture = picture_of(room.room(), 0, 5, width);
    EXPECT_EQ(companion_pixels(picture), 0);
    EXPECT_GT(psnr_db(picture, truth_at(room, 0, 5, width)), 30.0);
  }
  EXPECT_TRUE(hidden_in_views(room.room(), 0, 4, 96).empty());
}

TEST(StationPictures, MarksWhatIsHiddenInPart) {
  SyntheticRoomSpec spec = box_room(96);
  spec.companion = dolly(true);
  const TestRoom room(spec);
  // At 40 pixels the dolly's edge runs through pixels: nothing of the dolly may be mixed into a
  // pixel that is kept.
  cv::Mat picture = captured_picture_at(room.room(), 0, 6, 40);
  picture.setTo(cv::Scalar(0, 0, 0), hidden_in_views(room.room(), 0, 6, 40));
  const cv::Mat truth = averaged(truth_at(room, 0, 6, 96), 40);
  const cv::Mat kept = ~hidden_in_views(room.room(), 0, 6, 40);
  EXPECT_GT(psnr_db(picture, truth, kept), 50.0);
  EXPECT_GT(cv::countNonZero(kept), 40 * 20 * 8 / 10);
}

TEST(StationPictures, HaveTheirGainsApplied) {
  TestDirectory directory;
  SyntheticRoomSpec spec = box_room(96);
  spec.line_gain = {{"x0", 0.8}};
  write_synthetic_room(spec, directory / "room.lf");
  RoomManifest manifest = read_manifest(directory / "room.lf");
  GainFields gains = unit_gain_fields(manifest.grid);
  for (GainField& field : gains[0]) field.whole = {1.25F, 1.25F, 1.25F};
  write_gain_fields(gains_path(directory / "room.lf"), manifest.grid, gains);
  manifest.gains = true;
  write_file_atomically(manifest_path(directory / "room.lf"), manifest_to_json(manifest));
  const Room room = Room::open(directory / "room.lf");
  const Room bare = Room::open_without_gains(directory / "room.lf");
  spec.line_gain.clear();
  const TestRoom even(spec);
  EXPECT_GT(psnr_db(captured_picture_at(room, 0, 6, 96), truth_at(even, 0, 6, 96)), 50.0);
  EXPECT_LT(psnr_db(captured_picture_at(bare, 0, 6, 96), truth_at(even, 0, 6, 96)), 25.0);
}

}  // namespace
}  // namespace raywalk::render
