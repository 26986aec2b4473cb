#include "core/judge/trade/view_time.h"

#include <gtest/gtest.h>

#include <map>

namespace raywalk {
namespace {

TimedPair pair_of(double remap_ms, double view_ms) {
  return {{1e-3 * remap_ms, 2e-3 * remap_ms}, {1e-3 * view_ms, 1e-3 * view_ms}};
}

// Twelve pairs, the last `slow` of them with everything `factor` times as slow.
ViewTime time_with(int slow, double factor, double others_share = 0.0) {
  std::vector<TimedPair> pairs;
  for (int i = 0; i < 12; ++i) {
    const double by = i >= 12 - slow ? factor : 1.0;
    pairs.push_back(pair_of(10.0 * by, 30.0 * by));
  }
  return view_time_of(pairs, others_share);
}

TEST(ViewTime, IsTheMedianOfThePairs) {
  const ViewTime time = view_time_of(
      std::vector{pair_of(10.0, 30.0), pair_of(20.0, 30.0), pair_of(10.0, 50.0)}, 0.125);
  EXPECT_DOUBLE_EQ(time.ms, 30.0);
  EXPECT_DOUBLE_EQ(time.remap_ms, 10.0);
  EXPECT_DOUBLE_EQ(time.ratio, 3.0);
  EXPECT_DOUBLE_EQ(time.cpu_ratio, 1.5);
  EXPECT_DOUBLE_EQ(time.remap_spread, 1.0);
  EXPECT_EQ(time.others_share, 0.125);
}

TEST(ViewTime, AQuietMachineDisturbsNothing) {
  EXPECT_LE(disturbance(time_with(0, 1.0), 10.0), 0.0);
  EXPECT_LE(disturbance(time_with(6, 1.1), 10.0), 1.0);
  EXPECT_LE(disturbance(time_with(1, 5.0), 10.0), 1.0) << "the medians ignore a single hiccup";
  EXPECT_LE(disturbance(time_with(0, 1.0, 0.04), 10.0), 1.0);
}

TEST(ViewTime, UnsteadyRemapsSlowRemapsAndOtherProcessesDisturb) {
  EXPECT_GT(disturbance(time_with(5, 2.0), 10.0), 1.0) << "unsteady";
  EXPECT_LE(disturbance(time_with(12, 2.0), 20.0), 1.0) << "steady";
  EXPECT_GT(disturbance(time_with(12, 2.0), 10.0), 1.0) << "steadily slower than elsewhere";
  EXPECT_GT(disturbance(time_with(0, 1.0, 0.5), 10.0), 1.0) << "a core of two is taken";
}

TEST(RepeatDisturbed, MeasuresTheseAgainAndKeepsTheBetterOnes) {
  std::vector times{time_with(0, 1.0), time_with(6, 3.0), time_with(0, 1.0, 0.9)};
  std::map<std::size_t, int> measured, kept;
  std::vector<std::ptrdiff_t> rounds;
  repeat_disturbed(
      &times, [&](std::ptrdiff_t count) { rounds.push_back(count); },
      [&](std::size_t i) {
        ++measured[i];
        return i == 1 ? time_with(0, 1.0) : time_with(0, 1.0, measured[i] == 1 ? 0.95 : 0.5);
      },
      [&](std::size_t i) { ++kept[i]; });
  EXPECT_EQ(rounds, (std::vector<std::ptrdiff_t>{2, 1}));
  EXPECT_EQ(measured, (std::map<std::size_t, int>{{1, 1}, {2, kDisturbedRounds}}));
  EXPECT_EQ(kept, (std::map<std::size_t, int>{{1, 1}, {2, 1}}));
  EXPECT_EQ(disturbed(times), (std::vector{false, false, true}));
  EXPECT_EQ(times[2].others_share, 0.5);
}

// The first settings were measured while the machine was busy all the time.
TEST(RepeatDisturbed, FindsWhatLaterTimesReveal) {
  std::vector times{time_with(12, 2.0), time_with(12, 2.0)};
  EXPECT_EQ(disturbed(times), (std::vector{false, false}));
  times.push_back(time_with(0, 1.0));
  repeat_disturbed(
      &times, [](std::ptrdiff_t) {}, [](std::size_t) { return time_with(0, 1.0); },
      [](std::size_t) {});
  EXPECT_EQ(disturbed(times), (std::vector{false, false, false}));
  EXPECT_DOUBLE_EQ(times[0].remap_ms, 10.0);
}

}  // namespace
}  // namespace raywalk
