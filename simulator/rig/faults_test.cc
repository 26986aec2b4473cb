#include "simulator/rig/faults.h"

#include <gtest/gtest.h>

#include <map>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

using enum RigFault;

class FaultsTest : public ::testing::Test {
 protected:
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  bool lasts(RigFault kind) const { return faults_.lasting(kind).has_value(); }

  ManualClock clock_;
  Faults faults_{&clock_};
};

TEST_F(FaultsTest, PermanentOnesLastUntilMendedOthersOccurOnce) {
  faults_.add({.kind = kStall});
  faults_.add({.kind = kEmptyPicture});
  pass(1e6);
  EXPECT_TRUE(lasts(kStall));
  EXPECT_FALSE(lasts(kEmptyPicture));
  EXPECT_TRUE(faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  faults_.clear();
  EXPECT_FALSE(lasts(kStall));
}

TEST_F(FaultsTest, DelayAndDurationAreKept) {
  for (const RigFault kind : {kStall, kEmptyPicture}) {
    faults_.add({.kind = kind, .amount = 7.0, .for_ms = 100.0, .after_ms = 50.0});
  }
  EXPECT_FALSE(lasts(kStall));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(50.0));
  pass(50.0);
  EXPECT_EQ(faults_.lasting(kStall)->amount, 7.0);
  EXPECT_EQ(faults_.lasting(kStall)->since, clock_.now());
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(100.0));
  pass(100.0);
  EXPECT_FALSE(lasts(kStall));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.next_change(clock_.now()));
}

TEST_F(FaultsTest, EveryTriggerBeginsItsFault) {
  faults_.add({.kind = kStall, .at_request = 2});
  faults_.add({.kind = kBusy, .at_picture = 3});
  faults_.add({.kind = kCut, .at_station = "x0_001"});
  faults_.add({.kind = kLowLimit, .at_s = 10.0});
  faults_.next_exchange();
  faults_.picture_triggered(2);
  faults_.move_commanded("x0_002");
  pass(9999.0);
  for (const RigFault kind : {kStall, kBusy, kCut, kLowLimit}) EXPECT_FALSE(lasts(kind));
  faults_.next_exchange();
  faults_.picture_triggered(3);
  faults_.move_commanded("x0_001");
  pass(1.0);
  for (const RigFault kind : {kStall, kBusy, kCut, kLowLimit}) EXPECT_TRUE(lasts(kind));
}

LinkSettings every_kind() {
  LinkSettings link;
  link.late = link.lost = link.corrupted = link.duplicated = 0.02;
  return link;
}

TEST_F(FaultsTest, RandomOnesHaveTheGivenRatesAndRepeatForASeed) {
  Faults faults(&clock_, every_kind()), again(&clock_, every_kind());
  std::map<RigFault, int> counts;
  std::uint64_t all = 0;
  constexpr int kRequests = 20000;
  for (int i = 0; i < kRequests; ++i) {
    const auto fault = faults.next_exchange();
    EXPECT_EQ(again.next_exchange(), fault);
    if (!fault) continue;
    ++counts[*fault];
    ++all;
  }
  for (const auto& [kind, share] :
       {std::pair{kLate, 0.02}, std::pair{kDuplicated, 0.02}, std::pair{kLostRequest, 0.02},
        std::pair{kLostReply, 0.01}, std::pair{kCorruptedReply, 0.01}}) {
    EXPECT_NEAR(counts[kind], share * kRequests, 0.2 * share * kRequests) << name_of(kind);
  }
  EXPECT_EQ(faults.exchanges(), 20000U);
  EXPECT_EQ(faults.occurred(), all);
}

TEST_F(FaultsTest, OthersDoNotChangeTheRandomSequence) {
  Faults plain(&clock_, every_kind()), scheduled(&clock_, every_kind());
  scheduled.add({.kind = kLostReply, .at_request = 10});
  scheduled.add({.kind = kDuplicated});
  for (int request = 1; request <= 500; ++request) {
    const auto expected = plain.next_exchange(), fault = scheduled.next_exchange();
    const auto added = request == 1    ? std::optional(kDuplicated)
                       : request == 10 ? std::optional(kLostReply)
                                       : expected;
    EXPECT_EQ(fault, added) << request;
  }
}

}  // namespace
}  // namespace raywalk::simulator
