#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/median.h"
#include "core/base/pick_evenly.h"

namespace raywalk {
namespace {

TEST(Median, IsTheMiddleOfAnOddNumber) { EXPECT_EQ(median({5.0, -1.0, 3.0}), 3.0); }

TEST(Median, IsTheUpperMiddleOfAnEvenNumber) { EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 3.0); }

TEST(Median, OfOneValueIsThatValue) { EXPECT_EQ(median({7.5}), 7.5); }

std::vector<double> absolute_normal(double sigma, int count) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(std::fabs(normal(random)));
  return values;
}

TEST(RobustSigma, IsTheStandardDeviationOfNormalErrors) {
  EXPECT_NEAR(robust_sigma(absolute_normal(0.5, 100000)), 0.5, 0.005);
}

TEST(RobustSigma, IsHardlyMovedByOutliers) {
  std::vector<double> values = absolute_normal(0.5, 100000);
  values.insert(values.end(), 5000, 1e9);
  EXPECT_NEAR(robust_sigma(values), 0.5, 0.05);
}

TEST(RobustSigma, IsZeroWhereMostDeviationsAre) { EXPECT_EQ(robust_sigma({0, 0, 0, 7, 9}), 0.0); }

TEST(PickEvenly, TakesAllIfFewOtherwiseEvenly) {
  // The middles of equal parts.
  EXPECT_THAT(pick_evenly(100, 4), ::testing::ElementsAre(12, 37, 62, 87));
  EXPECT_THAT(pick_evenly(100, 1), ::testing::ElementsAre(50));
  EXPECT_THAT(pick_evenly(3, 3), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(3, 12), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(0, 12), ::testing::IsEmpty());
}

}  // namespace
}  // namespace raywalk
