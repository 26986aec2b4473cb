// Times that other programs disturb.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/judge/trade/trade_test_room.h"

namespace raywalk {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class DisturbedTradeTest : public TradeTest {
 protected:
  // Makes a trade while other programs take half of the processors during the measurements that
  // `is_disturbed` names, counted from 1. Returns how many were made.
  int trade_disturbed_at(const std::function<bool(int)>& is_disturbed) {
    TradeInput all = few();
    const TimeSource quiet = clock_.source();
    int measured = 0;
    bool begins = true;  // the processors' use is asked for before and after a measurement
    all.time_source.processor_use = [&] {
      if (begins) ++measured;
      clock_.others_share = !begins && is_disturbed(measured) ? 0.5 : 0.0;
      begins = !begins;
      return quiet.processor_use();
    };
    write_trade(all, options_.report);
    return measured;
  }
};

TEST_F(DisturbedTradeTest, QuietTimesAreNotMarked) {
  const std::string said = write_trade(few(), options_.report);
  EXPECT_EQ(written()["disturbed_settings"], 0);
  EXPECT_THAT(said, Not(HasSubstr("disturbed")));
}

TEST_F(DisturbedTradeTest, TimesOfABusyMachineAreMarkedEverywhere) {
  clock_.others_share = 0.5;
  const std::string said = write_trade(few(), options_.report);
  const json all = written();
  EXPECT_EQ(all["disturbed_settings"], 5);
  for (const json& setting : all["settings"]) EXPECT_EQ(setting["disturbed"], true);
  EXPECT_THAT(said, AllOf(HasSubstr("disturbed the times of 5 of 5 settings"),
                          HasSubstr("(time disturbed)"), HasSubstr("while nothing else runs")));
}

// One setting is timed while others take the processors, every time that it is tried.
TEST_F(DisturbedTradeTest, DisturbedSettingsAreTimedAgainAndLeftOutOfTheFront) {
  // The fifth, two-sided, and again.
  const int measured = trade_disturbed_at([](int measurement) { return measurement >= 5; });
  const json settings = written()["settings"];
  EXPECT_EQ(measured, 5 + kDisturbedRounds);
  EXPECT_EQ(written()["disturbed_settings"], 1);
  EXPECT_EQ(settings[4]["disturbed"], true);
  EXPECT_EQ(settings[4]["pareto"]["psnr_db"], false);
}

TEST_F(DisturbedTradeTest, ATimeThatSettlesIsNotMarked) {
  const int measured = trade_disturbed_at([](int measurement) { return measurement == 2; });
  EXPECT_EQ(measured, 6);
  EXPECT_EQ(written()["disturbed_settings"], 0);
}

}  // namespace
}  // namespace raywalk
