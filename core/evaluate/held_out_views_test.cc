#include "core/evaluate/held_out_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <set>

#include "core/base/error.h"
#include "core/evaluate/metrics.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/kept_stations.h"
#include "core/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

class HeldOutViewsTest : public ::testing::Test {
 protected:
  // A cell of 1 m, stations every 1/16 m from 1/4 m before it to 1/4 m behind it.
  Room room_of(SyntheticRoomSpec spec) {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  static SyntheticRoomSpec some_spec() {
    SyntheticRoomSpec spec;
    spec.spacing_m = 0.0625;
    spec.overhang_m = 0.25;
    spec.width = 64;
    return spec;
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(HeldOutViewsTest, TheRoomLacksTheStations) {
  const Room room = room_of(some_spec());
  const HeldOutViews held_out = held_out_views(room, 4, 100);
  ASSERT_FALSE(held_out.views.empty());
  std::set<std::string> names;
  for (const TrueView& view : held_out.views) {
    names.insert(view.name);
    ASSERT_TRUE(find_cell(room.grid(), view.viewpoint).has_value());
    for (int line = 0; line < 4; ++line) {
      const auto& all = room.grid().lines[static_cast<size_t>(line)];
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

TEST_F(HeldOutViewsTest, TruthsAreTheCapturedFrames) {
  const SyntheticRoomSpec spec = some_spec();
  const Room room = room_of(spec);
  const HeldOutViews held_out = held_out_views(room, 5, 3);
  EXPECT_THAT(held_out.views, Not(IsEmpty()));
  for (const TrueView& view : held_out.views) {
    EXPECT_EQ(cv::norm(view.image, render_truth(spec, view.viewpoint, spec.width), cv::NORM_INF),
              0.0);
    EXPECT_TRUE(view.mask.empty());
  }
}

TEST_F(HeldOutViewsTest, AreSpreadOverAllLines) {
  const HeldOutViews held_out = held_out_views(room_of(some_spec()), 4, 4);
  ASSERT_THAT(held_out.views, SizeIs(4));
  std::set<std::string> lines;
  for (const TrueView& view : held_out.views) lines.insert(view.name.substr(0, 2));
  EXPECT_THAT(lines, SizeIs(4));
}

TEST_F(HeldOutViewsTest, MaskedPixelsAreNotCompared) {
  SyntheticRoomSpec spec = some_spec();
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < -0.8; }};
  const HeldOutViews held_out = held_out_views(room_of(spec), 4, 2);
  EXPECT_THAT(held_out.views, Not(IsEmpty()));
  for (const TrueView& view : held_out.views) {
    ASSERT_EQ(view.mask.size(), view.image.size());
    EXPECT_EQ(view.mask.at<std::uint8_t>(0, 5), 255);
    EXPECT_EQ(view.mask.at<std::uint8_t>(view.mask.rows - 1, 5), 0);
  }
}

TEST_F(HeldOutViewsTest, ImpossibleHoldOutsAreRejected) {
  const Room room = room_of(some_spec());
  EXPECT_THROW(held_out_views(room, 1, 4), UsageError);
  EXPECT_THROW(held_out_views(room, 0, 4), UsageError);
  SyntheticRoomSpec sparse = some_spec();
  sparse.spacing_m = 1.0;
  sparse.overhang_m = 0.0;
  const auto from_sparse = [&] { return held_out_views(room_of(sparse), 8, 4); };
  EXPECT_THAT(from_sparse, ThrowsMessage<Error>(HasSubstr("true views with --truth")));
}

}  // namespace
}  // namespace raywalk
