#include "core/evaluate/held_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <set>

#include "core/base/test_error.h"
#include "core/evaluate/test_truths.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class HeldOutTest : public TruthTest {
 protected:
  // A cell of 1 m, stations every 1/16 m from 1/4 m before it to 1/4 m behind it.
  HeldOutTest() { make_room({.spacing_m = 0.0625, .overhang_m = 0.25, .width = 64}); }
};

TEST_F(HeldOutTest, TheRoomLacksTheStations) {
  const HeldOutViews held_out = held_out_views(room_, 4, 100);
  ASSERT_FALSE(held_out.views.empty());
  std::set<std::string> names;
  for (const TrueView& view : held_out.views) {
    names.insert(view.name);
    ASSERT_TRUE(find_cell(room_.grid(), view.viewpoint).has_value());
    for (int line = 0; line < 4; ++line) {
      const auto& all = room_.grid().lines[static_cast<size_t>(line)];
      const auto& left = held_out.room.grid().lines[static_cast<size_t>(line)];
      EXPECT_LT(left.stations.size(), all.stations.size());
      EXPECT_EQ(left.first_m(), all.first_m());
      EXPECT_EQ(left.last_m(), all.last_m());
      for (const Station& station : left.stations) EXPECT_NE(station.file, view.name + ".png");
      EXPECT_EQ(held_out.room.distances(line).maps(), static_cast<int>(left.stations.size()));
    }
  }
  EXPECT_EQ(names.size(), held_out.views.size());
}

TEST_F(HeldOutTest, TruthsAreTheCapturedFramesOfAllLines) {
  const HeldOutViews held_out = held_out_views(room_, 4, 4);
  ASSERT_THAT(held_out.views, SizeIs(4));
  std::set<std::string> lines;
  for (const TrueView& view : held_out.views) {
    lines.insert(view.name.substr(0, 2));
    EXPECT_EQ(view.width, 64);
    EXPECT_EQ(cv::norm(view.image, render_truth(spec_, view.viewpoint, 64), cv::NORM_INF), 0.0);
    EXPECT_TRUE(view.mask.empty());
  }
  EXPECT_THAT(lines, SizeIs(4));
}

TEST_F(HeldOutTest, MaskedPixelsAreNotCompared) {
  spec_.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < -0.8; }};
  make_room(spec_);
  for (const TrueView& view : held_out_views(room_, 4, 2).views) {
    ASSERT_EQ(view.mask.size(), view.image.size());
    EXPECT_EQ(view.mask.at<std::uint8_t>(0, 5), 255);
    EXPECT_EQ(view.mask.at<std::uint8_t>(view.mask.rows - 1, 5), 0);
  }
}

TEST_F(HeldOutTest, ImpossibleHoldOutsAreRejected) {
  EXPECT_THROW(held_out_views(room_, 1, 4), UsageError);
  EXPECT_THROW(held_out_views(room_, 0, 4), UsageError);
  make_room({.spacing_m = 1.0, .width = 64});
  EXPECT_THAT(error_of([&] { held_out_views(room_, 8, 4); }), HasSubstr("true views with --truth"));
}

}  // namespace
}  // namespace raywalk
