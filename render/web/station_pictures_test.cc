#include "render/web/station_pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/view/test_gains.h"
#include "core/view/test_room.h"
#include "render/web/inverse_file.h"
#include "render/web/station_distances.h"
#include "render/web/test_inverse.h"

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
  SyntheticRoomSpec spec = box_room(96);
  const TestRoom even(spec);
  spec.line_gain = {{"x0", 0.8}};
  const RoomWithGains room(spec, [](int line, int) {
    return line == 0 ? GainField{.whole = {1.25F, 1.25F, 1.25F}} : GainField{};
  });
  const Room bare = Room::open_without_gains(room.room().directory());
  const cv::Mat truth = truth_at(even, 0, 6, 96);
  EXPECT_GT(psnr_db(captured_picture_at(room.room(), 0, 6, 96), truth), 50.0);
  EXPECT_LT(psnr_db(captured_picture_at(bare, 0, 6, 96), truth), 25.0);
}

const Eigen::Vector3d& position_m(const Room& room, int line, int station) {
  return room.grid().station({line, station}).position_m;
}

double true_inverse(const TestRoom& room, int line, int station, const InverseMap& map, int theta,
                    int row) {
  return 1.0 / distance_at(room.spec().scene, position_m(room.room(), line, station),
                           direction_from_angles(
                               angles_from_pixel({double(theta), double(row)}, map.size())));
}

// Share of the pixels within 3 % of the truth.
double share_right(const TestRoom& room, int line, int station, const InverseMap& map) {
  int right = 0;
  for (int theta = 0; theta < map.size().width; ++theta) {
    for (int row = 0; row < map.size().height; ++row) {
      const double truth = true_inverse(room, line, station, map, theta, row);
      if (std::abs(map.at(theta, row) - truth) <= 0.03 * truth) ++right;
    }
  }
  return static_cast<double>(right) / static_cast<double>(map.values().size());
}

bool complete(const InverseMap& map) {
  return std::ranges::all_of(
      map.values(), [](float inverse) { return std::isfinite(inverse) && inverse >= 0.0F; });
}

TEST(StationDistances, AreThoseOfTheStationsOwnMap) {
  const TestRoom room(box_room(64));
  const InverseMap map = StationDistances(room.room(), 64).seen_from(1, 5);
  for (int theta = 0; theta < 64; ++theta) {
    for (int row = 0; row < 32; ++row) {
      const double truth = true_inverse(room, 1, 5, map, theta, row);
      EXPECT_NEAR(map.at(theta, row), truth, 1e-6 * truth) << theta << ',' << row;
    }
  }
}

TEST(StationDistances, AreRightWithoutAnOwnMapAndAtOtherWidths) {
  SyntheticRoomSpec spec = box_room(128);
  spec.distance_every = 3;
  const TestRoom room(spec);
  for (const int width : {128, 64, 44}) {
    StationDistances distances(room.room(), width);
    for (const int station : {0, 1, 7, 12}) {
      const InverseMap map = distances.seen_from(2, station);
      EXPECT_EQ(map.size().width, width);
      EXPECT_TRUE(complete(map));
      EXPECT_GT(share_right(room, 2, station, map), 0.93) << width << " at " << station;
    }
  }
}

TEST(StationDistances, DoNotMixSurfacesAtSilhouettes) {
  SyntheticRoomSpec spec = box_room(256);
  spec.scene.obstacle = SceneBox{{-0.15, -1.2, -0.15}, {0.15, 0.6, 0.15}};
  const TestRoom room(spec);
  const InverseMap map = StationDistances(room.room(), 64).seen_from(0, 6);
  // In the middle row the obstacle is 0.35 m away or more than 0.7 m nearer than any wall.
  for (int theta = 0; theta < 64; ++theta) {
    const float inverse = map.at(theta, 16);
    EXPECT_TRUE(inverse > 1.8F || inverse < 0.65F) << theta << ": " << 1.0F / inverse << " m";
  }
}

TEST(StationDistances, FillWhatTheMapsDoNotKnowAsViewsDo) {
  SyntheticRoomSpec spec = box_room(64);
  // Nothing is known of a part of the walls and of the zenith, from anywhere.
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return v < 6 || (u > 20 && u < 40 && v > 10 && v < 20) ? 0 : 255;
  };
  const TestRoom room(spec);
  const InverseMap map = StationDistances(room.room(), 64).seen_from(3, 6);
  EXPECT_TRUE(complete(map));
  EXPECT_GT(share_right(room, 3, 6, map), 0.6) << "of the 73 % that are known, most";

  DistanceView view(room.room());
  const Eigen::Vector3d& at_m = position_m(room.room(), 3, 6);
  const MapSpread spread = map_spread(room.room().grid(), {at_m.x(), at_m.z()});
  const std::vector<int> lines{0, 1, 2, 3};
  view.compute(nearest_maps(room.room(), lines, at_m, spread.gap_m, spread.most_per_line,
                            ViewOptions().distance_maps),
               at_m);
  EXPECT_EQ(map.at(30, 15), view.column(30)[15]);
  EXPECT_EQ(map.at(3, 2), view.column(3)[2]);
  EXPECT_GT(map.at(30, 15), 0.0F);
}

TEST(StationDistances, AreIgnoredBelowTheConfidenceOfViews) {
  SyntheticRoomSpec spec = box_room(64);
  spec.stored_distance = [](int u, int v, double exact_m) {
    return static_cast<float>(u == 10 && v == 16 ? 0.01 : exact_m);
  };
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return u == 10 && v == 16 ? kMinConfidence - 1 : 255;
  };
  const TestRoom room(spec);
  EXPECT_LT(StationDistances(room.room(), 64).seen_from(0, 6).at(10, 16), 2.0F);
}

TEST(InverseFile, HoldsFallsAndRisesOverTheWholeRange) {
  InverseMap map({16, 8});
  for (int theta = 0; theta < 16; ++theta) {
    for (int row = 0; row < 8; ++row) map.at(theta, row) = (theta + row) % 2 == 0 ? 0.0F : 2.0F;
  }
  map.at(3, 4) = 5.0F;  // too near, which becomes the nearest
  const double step_per_m = 2.0 / kLargestInverseValue;
  const InverseMap read = decoded_inverse(encode_inverse(map, step_per_m), 16, step_per_m);
  map.at(3, 4) = 2.0F;
  EXPECT_TRUE(std::ranges::equal(read.values(), map.values()));
}

TEST(InverseFile, SmoothDistancesAreFewBytes) {
  InverseMap map({512, 256});
  for (int theta = 0; theta < 512; ++theta) {
    for (int row = 0; row < 256; ++row) {
      map.at(theta, row) = static_cast<float>(std::sin(0.01 * row) * std::cos(0.01 * theta) + 1.0);
    }
  }
  EXPECT_LT(encode_inverse(map, 2.0 / kLargestInverseValue).size(), map.values().size_bytes() / 6);
}

}  // namespace
}  // namespace raywalk::render
