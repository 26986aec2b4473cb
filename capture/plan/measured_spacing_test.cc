#include "capture/plan/measured_spacing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using testing::SizeIs;

// At a share of 0.1, 0.2 and 0.4 of one metre, and at 0.2 and 0.4 of two metres.
constexpr const char* kTable =
    "room,panorama_width_px,stations,spacing_mm,nearest_m,median_m,two_sided_db,two_sided_worst_db,"
    "hlf_vd_db,hlf_vd_worst_db\n"
    "near,512,9,200,1,2,36,33,30,29\n"
    "near,512,20,100,1,2,37,34,30,29\n"
    "near,512,5,400,1,2,33,30,30,29\n"
    "far,512,9,400,2,3,32,31,30,29\n"
    "far,512,5,800,2,3,31,29,30,29\n";

std::vector<MeasuredRoom> two_rooms() { return parse_measured_rooms(kTable, "table.csv"); }

TEST(MeasuredSpacingTest, RoomsAreComparedAtTheSameShareOfTheirNearestSurface) {
  const auto quality = expected_quality(two_rooms(), 0.2);
  ASSERT_TRUE(quality);
  EXPECT_EQ(quality->rooms, 2);
  EXPECT_NEAR(quality->mean_db.least, 32.0, 1e-9);
  EXPECT_NEAR(quality->mean_db.most, 36.0, 1e-9);
  EXPECT_NEAR(quality->worst_db, 31.0, 1e-9);
  ASSERT_TRUE(quality->lost_by_twice_db);
  EXPECT_NEAR(quality->lost_by_twice_db->least, 1.0, 1e-9);
  EXPECT_NEAR(quality->lost_by_twice_db->most, 3.0, 1e-9);
  ASSERT_TRUE(quality->gained_by_half_db);
  EXPECT_NEAR(quality->gained_by_half_db->least, 1.0, 1e-9) << "of the nearer room only";
  EXPECT_NEAR(quality->gained_by_half_db->most, 1.0, 1e-9);
}

// The middle of 0.1 and 0.2 on a logarithmic scale is 0.1 sqrt 2.
TEST(MeasuredSpacingTest, BetweenMeasurementsTheLogarithmIsInterpolated) {
  const auto quality = expected_quality(two_rooms(), 0.141421356);
  ASSERT_TRUE(quality);
  EXPECT_EQ(quality->rooms, 1);
  EXPECT_NEAR(quality->mean_db.most, 36.5, 1e-6);
  EXPECT_NEAR(quality->worst_db, 33.5, 1e-6);
  EXPECT_FALSE(quality->gained_by_half_db);
}

TEST(MeasuredSpacingTest, NothingIsClaimedOutsideOfWhatWasMeasured) {
  EXPECT_FALSE(expected_quality(two_rooms(), 0.09));
  EXPECT_FALSE(expected_quality(two_rooms(), 0.41));
  const MeasuredShares shares = measured_shares(two_rooms());
  EXPECT_NEAR(shares.least, 0.1, 1e-12);
  EXPECT_NEAR(shares.most, 0.4, 1e-12);
}

TEST(MeasuredSpacingTest, DamagedTableIsRefused) {
  EXPECT_THROW(parse_measured_rooms("room,spacing_mm\na,1\n", "table.csv"), Error);
}

// What is compiled in comes from scripts/measure-spacing; whatever it measured must make sense.
TEST(MeasuredSpacingTest, CompiledTableHoldsSeveralRooms) {
  ASSERT_GE(measured_rooms().size(), 2U);
  for (const MeasuredRoom& room : measured_rooms()) {
    EXPECT_GE(room.spacings.size(), 3U) << room.name;
    for (const MeasuredSpacing& spacing : room.spacings) {
      EXPECT_GT(spacing.spacing_share, 0.0);
      EXPECT_GT(spacing.worst_db, 10.0);
      EXPECT_GE(spacing.mean_db, spacing.worst_db);
      EXPECT_LT(spacing.mean_db, 60.0);
    }
  }
}

}  // namespace
}  // namespace raywalk::capture
