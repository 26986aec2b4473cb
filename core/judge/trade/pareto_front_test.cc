#include "core/judge/trade/pareto_front.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace raywalk {
namespace {

using testing::ElementsAre;

bool beats(const TradePoint& a, const TradePoint& b) {
  return a.cost <= b.cost && a.gain >= b.gain && (a.cost < b.cost || a.gain > b.gain);
}

// Whole numbers in a small range, so that many points are equal in one or both.
TEST(ParetoFront, HoldsThePointsThatNoOtherDominates) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    std::uniform_int_distribution<int> count(1, 40), value(0, 2 + round % 20);
    std::vector<TradePoint> points(static_cast<std::size_t>(count(random)));
    for (TradePoint& point : points) {
      point = {static_cast<double>(value(random)), static_cast<double>(value(random))};
    }
    const std::vector<bool> front = pareto_front(points);
    ASSERT_EQ(front.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool beaten = false;
      for (const TradePoint& other : points) beaten = beaten || beats(other, points[i]);
      EXPECT_EQ(front[i], !beaten) << points[i].cost << ' ' << points[i].gain;
    }
  }
}

TEST(ParetoFront, NeverHoldsPointsThatAreNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<TradePoint> points{
      {1.0, kNan}, {kNan, 50.0}, {2.0, 30.0}, {0.5, -kInfinity}, {kInfinity, 40.0}};
  EXPECT_THAT(pareto_front(points), ElementsAre(false, false, true, false, false));
  EXPECT_TRUE(pareto_front({}).empty());
}

}  // namespace
}  // namespace raywalk
