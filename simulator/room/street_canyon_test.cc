#include "simulator/room/street_canyon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

using ::testing::HasSubstr;

constexpr PanoramaSize kStreetSize{256, 128};

VirtualRoomSettings canyon_of(int seed) {
  VirtualRoomSettings settings;
  settings.seed = seed;
  settings.place = "canyon";
  settings.canyon.stations = 3;
  settings.canyon.spacing_max_m = 1.0;
  settings.canyon.width_m = 10.0;
  return settings;
}

class StreetCanyonTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { street_ = std::make_unique<const VirtualRoom>(canyon_of(1)); }
  static void TearDownTestSuite() { street_.reset(); }
  static std::unique_ptr<const VirtualRoom> street_;
};

std::unique_ptr<const VirtualRoom> StreetCanyonTest::street_;

// Facades are at 5 m, with recesses, ledges and balconies; the roadway is 2.2 to 2.6 m below.
TEST_F(StreetCanyonTest, FacadesStandAtTheSidesAndTheSkyIsOpen) {
  const cv::Mat map = street_->distance_map({}, kStreetSize);
  for (const int u : {63, 191}) {  // left and right
    for (int v = 40; v < 64; ++v) {
      const double phi = kHalfPi - (v + 0.5) * kPi / 128.0;
      const double across = map.at<float>(v, u) * std::cos(phi);
      EXPECT_GT(across, 4.3) << u << "," << v;
      EXPECT_LT(across, 5.35) << u << "," << v;
    }
  }
  const double below_m = map.at<float>(127, 0);
  EXPECT_GT(below_m, 2.19);
  EXPECT_LT(below_m, 2.61);
  const cv::Mat above = map.rowRange(0, 64), ground = map.rowRange(64, 128);
  const auto far = [](float metres) { return std::isinf(metres); };
  const auto sky = std::count_if(above.begin<float>(), above.end<float>(), far);
  EXPECT_GT(sky, 0.15 * 256 * 64);
  EXPECT_LT(sky, 0.8 * 256 * 64);
  EXPECT_EQ(std::count_if(ground.begin<float>(), ground.end<float>(), far), 0);
}

TEST_F(StreetCanyonTest, PicturesAreNeitherDarkNorWhite) {
  const cv::Scalar mean = cv::mean(street_->panorama({}, kStreetSize, Sampling::kDraft));
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_GT(mean[channel], 60.0);
    EXPECT_LT(mean[channel], 220.0);
  }
}

TEST(CanyonPlanTest, StationsAreUnevenlySpacedWithinTheGivenRange) {
  VirtualRoomSettings settings = canyon_of(2);
  settings.canyon = {};
  const RoomPlan plan = plan_canyon(settings);
  ASSERT_EQ(plan.lines.size(), 1U);
  const std::vector<double>& along = plan.lines.front().along;
  ASSERT_EQ(along.size(), 21U);
  double least = 10.0, most = 0.0;
  for (std::size_t i = 1; i < along.size(); ++i) {
    least = std::min(least, along[i] - along[i - 1]);
    most = std::max(most, along[i] - along[i - 1]);
  }
  EXPECT_GE(least, 0.5);
  EXPECT_LT(least, 1.5);
  EXPECT_LE(most, 4.0);
  EXPECT_GT(most, 3.0);
  EXPECT_NEAR(along.front(), -along.back(), 1e-9);
  const double width = plan.walls.x_max - plan.walls.x_min;
  EXPECT_GE(width, 8.0);
  EXPECT_LE(width, 12.0);
}

TEST(CanyonPlanTest, ImpossibleStreetsAreRefused) {
  const auto expect_refused = [](const VirtualRoomSettings& settings, const char* key) {
    try {
      plan_canyon(settings);
      ADD_FAILURE() << key;
    } catch (const UsageError& e) {
      EXPECT_THAT(e.what(), HasSubstr(key));
    }
  };
  VirtualRoomSettings settings = canyon_of(1);
  settings.canyon.spacing_min_m = 3.0;
  expect_refused(settings, "canyon.spacing_max_m");
  settings = canyon_of(1);
  settings.canyon.width_m = 3.0;
  expect_refused(settings, "canyon.width_m");
  settings = canyon_of(1);
  settings.room.camera_height_m = 0.1;
  expect_refused(settings, "room.camera_height_m");
}

}  // namespace
}  // namespace raywalk::capture
