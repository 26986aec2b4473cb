#include "simulator/rig/faults.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

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
  const std::vector<RigFault> kinds{kStall, kBusy, kCut, kLowLimit};
  faults_.add({.kind = kStall, .at_request = 2});
  faults_.add({.kind = kBusy, .at_picture = 3});
  faults_.add({.kind = kCut, .at_station = "x0_001"});
  faults_.add({.kind = kLowLimit, .at_s = 10.0});
  faults_.next_exchange();
  faults_.picture_triggered(2);
  faults_.move_commanded("x0_002");
  pass(9999.0);
  for (const RigFault kind : kinds) EXPECT_FALSE(lasts(kind));
  faults_.next_exchange();
  faults_.picture_triggered(3);
  faults_.move_commanded("x0_001");
  pass(1.0);
  for (const RigFault kind : kinds) EXPECT_TRUE(lasts(kind));
}

// They depend on the seed alone; those that are added do not change the random sequence.
TEST_F(FaultsTest, RandomOnesHaveTheGivenRatesAndRepeatForASeed) {
  LinkSettings link;
  link.late = link.lost = link.corrupted = link.duplicated = 0.02;
  Faults faults(&clock_, link), again(&clock_, link);
  again.add({.kind = kLostReply, .at_request = 10});
  again.add({.kind = kDuplicated});
  std::map<RigFault, int> counts;
  std::uint64_t all = 0;
  constexpr int kRequests = 20000;
  for (int request = 1; request <= kRequests; ++request) {
    const auto fault = faults.next_exchange(), repeated = again.next_exchange();
    EXPECT_EQ(repeated, request == 1    ? std::optional(kDuplicated)
                        : request == 10 ? std::optional(kLostReply)
                                        : fault);
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

}  // namespace
}  // namespace raywalk::simulator
