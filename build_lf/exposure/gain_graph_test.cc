#include "build_lf/exposure/gain_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace raywalk::build_lf {
namespace {

// Ratios between neighbours and next neighbours of pictures with these log gains.
std::vector<GainEquation> chain(const std::vector<double>& gains, double error) {
  std::vector<GainEquation> equations;
  const int count = static_cast<int>(gains.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < std::min(i + 3, count); ++j) {
      const double difference =
          gains[static_cast<std::size_t>(i)] - gains[static_cast<std::size_t>(j)];
      equations.push_back({i, j, difference, error});
    }
  }
  return equations;
}

TEST(GainGraph, ExactRatiosGiveTheGainsUpToTheirMean) {
  const std::vector<double> gains = {0.3, -0.1, 0.02, 0.0, -0.22};  // mean 0
  const Eigen::VectorXd found = solve_gain_graph(chain(gains, 0.01), 5);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(found[i], gains[static_cast<std::size_t>(i)], 1e-6);
}

TEST(GainGraph, EveryPartHasAMeanOfZero) {
  // 0 - 1 and 2 - 3 - 4; 5 alone.
  const std::vector<GainEquation> equations = {
      {0, 1, 0.4, 0.1}, {2, 3, 0.3, 0.01}, {3, 4, 0.3, 2.0}};
  const Eigen::VectorXd found = solve_gain_graph(equations, 6);
  EXPECT_NEAR(found[0], 0.2, 1e-6);
  EXPECT_NEAR(found[1], -0.2, 1e-6);
  EXPECT_NEAR(found[2] + found[3] + found[4], 0.0, 1e-6);
  EXPECT_NEAR(found[2] - found[4], 0.6, 1e-4);
  EXPECT_EQ(found[5], 0.0);
}

TEST(GainGraph, IsRobustToAnOutlier) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 0.005);
  std::vector<double> gains(30);
  double mean = 0.0;
  for (double& gain : gains) mean += (gain = 10.0 * normal(random)) / 30.0;
  std::vector<GainEquation> equations = chain(gains, 0.005);
  for (GainEquation& equation : equations) equation.difference += normal(random);
  equations[20].difference += 3.0;
  const Eigen::VectorXd found = solve_gain_graph(equations, 30);
  for (int i = 0; i < 30; ++i) {
    EXPECT_NEAR(found[i], gains[static_cast<std::size_t>(i)] - mean, 0.03) << i;
  }
}

TEST(GainGraph, ExtremeErrorsStayFinite) {
  for (const double error : {1e-3, 1.0, 1e3}) {
    const Eigen::VectorXd found = solve_gain_graph({{0, 1, 0.5, error}, {1, 2, -0.5, 1.0}}, 3);
    EXPECT_TRUE(found.allFinite()) << error;
    EXPECT_NEAR(found[0] - found[1], 0.5, 2e-3) << error;
  }
  EXPECT_EQ(solve_gain_graph({}, 0).size(), 0);
}

}  // namespace
}  // namespace raywalk::build_lf
