#include "simulator/rig/link_faults.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;

LinkFaultRates every_kind() {
  LinkFaultRates rates;
  rates.late = rates.lost = rates.corrupted = rates.duplicated = 0.02;
  return rates;
}

TEST(LinkFaultsTest, HaveTheGivenRatesAndRepeatForASeed) {
  LinkFaults faults(every_kind()), again(every_kind());
  std::map<LinkFault, int> counts;
  constexpr int kRequests = 20000;
  for (int i = 0; i < kRequests; ++i) {
    const LinkFault fault = faults.next();
    EXPECT_EQ(again.next(), fault);
    ++counts[fault];
  }
  const auto expect_share = [&](LinkFault fault, double share) {
    EXPECT_NEAR(counts[fault], share * kRequests, 0.2 * share * kRequests);
  };
  expect_share(LinkFault::kLate, 0.02);
  expect_share(LinkFault::kLostRequest, 0.01);
  expect_share(LinkFault::kLostReply, 0.01);
  expect_share(LinkFault::kCorruptedRequest, 0.01);
  expect_share(LinkFault::kCorruptedReply, 0.01);
  expect_share(LinkFault::kDuplicated, 0.02);
  EXPECT_EQ(faults.requests(), 20000U);
  EXPECT_EQ(faults.faults(), 20000U - static_cast<unsigned>(counts[LinkFault::kNone]));
}

TEST(LinkFaultsTest, ScheduledAndInjectedFaultsDoNotChangeTheRandomSequence) {
  LinkFaults plain(every_kind()), scheduled(every_kind());
  scheduled.schedule(LinkFault::kLostReply, 10, milliseconds(0));
  scheduled.schedule(LinkFault::kLate, 11, milliseconds(0));
  scheduled.inject(LinkFault::kDuplicated, 2);
  for (int request = 1; request <= 500; ++request) {
    const LinkFault expected = plain.next(), fault = scheduled.next();
    if (request <= 2) {
      EXPECT_EQ(fault, LinkFault::kDuplicated);
    } else if (request == 10) {
      EXPECT_EQ(fault, LinkFault::kLostReply);
    } else if (request == 11) {
      EXPECT_EQ(fault, LinkFault::kLate);
    } else {
      EXPECT_EQ(fault, expected) << request;
    }
  }
}

TEST(LinkFaultsTest, CutEndsByRestoreOrAfterItsDuration) {
  LinkFaults faults({});
  EXPECT_FALSE(faults.is_cut());
  faults.cut(milliseconds(0));
  EXPECT_TRUE(faults.is_cut());
  faults.restore();
  EXPECT_FALSE(faults.is_cut());
  faults.schedule(LinkFault::kCut, 2, milliseconds(20));
  EXPECT_EQ(faults.next(), LinkFault::kNone);
  EXPECT_EQ(faults.next(), LinkFault::kCut);
  EXPECT_TRUE(faults.is_cut());
  const auto begin = std::chrono::steady_clock::now();
  while (faults.is_cut()) {
    ASSERT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  }
}

TEST(LinkFaultsTest, TimedFaultsOccurAtTheirTime) {
  LinkFaults faults({});
  faults.schedule_in(LinkFault::kLostReply, milliseconds(0), milliseconds(0));
  faults.schedule_in(LinkFault::kLate, std::chrono::hours(1), milliseconds(0));
  faults.schedule_in(LinkFault::kCut, milliseconds(20), milliseconds(0));
  EXPECT_EQ(faults.next(), LinkFault::kLostReply);
  EXPECT_EQ(faults.next(), LinkFault::kNone);
  const auto begin = std::chrono::steady_clock::now();
  while (!faults.is_cut()) {
    ASSERT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  }
  faults.restore();
  EXPECT_FALSE(faults.is_cut());
  EXPECT_EQ(faults.faults(), 2U);
}

TEST(LinkFaultsTest, CorruptedBytesDifferInOneBitOrLength) {
  LinkFaults faults({});
  const ModbusBytes sent{1, 3, 4, 0, 0, 0x12, 0x34, 0xaa, 0x55};
  int shorter = 0;
  for (int i = 0; i < 400; ++i) {
    const ModbusBytes received = faults.corrupt(sent);
    if (received.size() + 1 == sent.size()) {
      ++shorter;
      continue;
    }
    ASSERT_EQ(received.size(), sent.size());
    int bits = 0;
    for (std::size_t k = 0; k < sent.size(); ++k) {
      bits += std::popcount(static_cast<unsigned>(sent[k] ^ received[k]));
    }
    EXPECT_EQ(bits, 1);
  }
  EXPECT_GT(shorter, 0);
  EXPECT_LT(shorter, 200);
}

}  // namespace
}  // namespace raywalk::capture
