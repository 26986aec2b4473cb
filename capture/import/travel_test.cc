#include "capture/import/travel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace raywalk::capture {
namespace {

using namespace std::chrono_literals;
using testing::DoubleNear;
using testing::Optional;

const WallTime kEpoch = std::chrono::sys_days{std::chrono::year{2026} / 5 / 1};

TEST(Travel, PositionsAreInterpolatedAndRestAtBothEnds) {
  const Travel travel("x0", {10.0, 11.0, 13.0}, {100.0, 120.0, 200.0});
  EXPECT_THAT(travel.position_mm(10.5), Optional(DoubleNear(110.0, 1e-9)));
  EXPECT_THAT(travel.position_mm(12.0), Optional(DoubleNear(160.0, 1e-9)));
  EXPECT_THAT(travel.position_mm(9.0), Optional(100.0));
  EXPECT_THAT(travel.position_mm(14.0), Optional(200.0));
}

TEST(Travel, ThePositionIsUnknownBeyondTheRest) {
  const Travel travel("x0", {10.0, 11.0}, {100.0, 120.0});
  EXPECT_FALSE(travel.position_mm(10.0 - Travel::kRest_s - 0.01));
  EXPECT_FALSE(travel.position_mm(11.0 + Travel::kRest_s + 0.01));
}

TEST(Travel, SpeedIsTheMeanAbsoluteSpeed) {
  const Travel forth("x0", {0.0, 1.0, 2.0}, {0.0, 10.0, 40.0});
  EXPECT_DOUBLE_EQ(forth.speed_mm_s(0.5, 1.5), 20.0);
  const Travel back("x0", {0.0, 1.0}, {10.0, 0.0});
  EXPECT_DOUBLE_EQ(back.speed_mm_s(0.0, 1.0), 10.0);
}

TEST(Travel, AGapInTheJournalSplitsIt) {
  const std::vector<JournalSample> journal{
      {kEpoch, 0.0}, {kEpoch + 500ms, 5.0}, {kEpoch + 90s, 0.0}, {kEpoch + 90500ms, 7.0}};
  const auto travels = travels_of("z1", journal, kEpoch);
  ASSERT_EQ(travels.size(), 2U);
  EXPECT_EQ(travels[0].line(), "z1");
  EXPECT_THAT(travels[0].position_mm(0.25), Optional(DoubleNear(2.5, 1e-9)));
  EXPECT_THAT(travels[1].position_mm(90.25), Optional(DoubleNear(3.5, 1e-9)));
  EXPECT_FALSE(travels[0].position_mm(45.0));
}

TEST(Travel, SamplesOutOfOrderAreDropped) {
  const std::vector<JournalSample> journal{{kEpoch, 0.0},
                                           {kEpoch + 500ms, 5.0},
                                           {kEpoch + 200ms, 99.0},
                                           {kEpoch + 500ms, 99.0},
                                           {kEpoch + 1s, 10.0}};
  const auto travels = travels_of("z1", journal, kEpoch);
  ASSERT_EQ(travels.size(), 1U);
  EXPECT_THAT(travels[0].position_mm(0.75), Optional(DoubleNear(7.5, 1e-9)));
}

TEST(Travel, ASingleSampleGivesNoTravel) {
  const std::vector<JournalSample> journal{{kEpoch, 0.0}};
  EXPECT_TRUE(travels_of("x0", journal, kEpoch).empty());
  EXPECT_TRUE(travels_of("x0", {}, kEpoch).empty());
}

}  // namespace
}  // namespace raywalk::capture
