#include "core/evaluate/trade/view_time.h"

#include <gtest/gtest.h>

#include <vector>

namespace raywalk {
namespace {

TimedPair pair_of(double remap_ms, double view_ms) { return {1e-3 * remap_ms, 1e-3 * view_ms}; }

TEST(ViewTime, IsTheMedianOfThePairs) {
  const ViewTime time =
      view_time_of(std::vector{pair_of(10.0, 30.0), pair_of(20.0, 30.0), pair_of(10.0, 50.0)});
  EXPECT_DOUBLE_EQ(time.ms, 30.0);
  EXPECT_DOUBLE_EQ(time.remap_ms, 10.0);
  EXPECT_DOUBLE_EQ(time.ratio, 3.0);
  EXPECT_DOUBLE_EQ(time.remap_spread, 1.0);
}

TEST(ViewTime, OnlyUnsteadyRemapsAreOfABusyMachine) {
  const auto spread = [](int slow, double factor) {
    std::vector<TimedPair> pairs;
    for (int i = 0; i < 12; ++i) {
      pairs.push_back(pair_of(i < slow ? 10.0 * factor : 10.0, 30.0));
    }
    return view_time_of(pairs).remap_spread;
  };
  EXPECT_LT(spread(6, 1.1), kBusySpread);
  EXPECT_LT(spread(1, 5.0), kBusySpread) << "a single hiccup";
  EXPECT_LT(spread(12, 2.0), kBusySpread) << "a slow machine";
  EXPECT_GT(spread(5, 2.0), kBusySpread);
}

}  // namespace
}  // namespace raywalk
