#include "core/judge/trade/rank_correlation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace raywalk {
namespace {

using ::testing::ElementsAre;

TEST(RankCorrelationTest, EqualValuesShareTheirRanks) {
  EXPECT_THAT(ranks_of(std::vector<double>{3.0, 1.0, 3.0, 2.0, 3.0}), ElementsAre(4, 1, 4, 2, 4));
}

TEST(RankCorrelationTest, AgreesWithTheFormulaOfDifferencesWithoutTies) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-6.0, 8.0);
  for (int n = 2; n < 40; ++n) {
    std::vector<double> a, b;
    for (int i = 0; i < n; ++i) {
      a.push_back(std::pow(10.0, exponent(random)));
      b.push_back(std::pow(10.0, exponent(random)));
    }
    double squares = 0.0;
    const auto ranks_a = ranks_of(a);
    const auto ranks_b = ranks_of(b);
    for (std::size_t i = 0; i < a.size(); ++i) squares += std::pow(ranks_a[i] - ranks_b[i], 2);
    EXPECT_NEAR(rank_correlation(a, b), 1.0 - 6.0 * squares / (n * (double(n) * n - 1.0)), 1e-12);
  }
}

TEST(RankCorrelationTest, OnlyTheOrderCounts) {
  const std::vector<double> a{1.0, 2.0, 3.0, 4.0};
  EXPECT_DOUBLE_EQ(rank_correlation(a, std::vector<double>{-5.0, 0.0, 1e-9, 1e9}), 1.0);
  EXPECT_DOUBLE_EQ(rank_correlation(a, std::vector<double>{4.0, 3.0, 2.0, -1e300}), -1.0);
}

TEST(RankCorrelationTest, IsNanWithoutAnOrder) {
  EXPECT_TRUE(std::isnan(rank_correlation(std::vector<double>{}, std::vector<double>{})));
  EXPECT_TRUE(std::isnan(rank_correlation(std::vector<double>{1.0}, std::vector<double>{2.0})));
  EXPECT_TRUE(
      std::isnan(rank_correlation(std::vector<double>{1.0, 2.0}, std::vector<double>{3.0, 3.0})));
}

}  // namespace
}  // namespace raywalk
