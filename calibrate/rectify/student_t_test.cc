#include "calibrate/rectify/student_t.h"

#include <gtest/gtest.h>

namespace raywalk::calibrate {
namespace {

// From tables of the distribution.
TEST(StudentTTest, QuantilesAreThoseOfTables) {
  EXPECT_NEAR(two_sided_quantile(0.05, 1), 12.7062, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.01, 2), 9.9248, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.01, 10), 3.1693, 1e-4);
  EXPECT_NEAR(two_sided_quantile(0.001, 23), 3.7676, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.05, 1000), 1.9623, 1e-3);
}

TEST(StudentTTest, ProbabilityAndQuantileAreInverse) {
  for (const int freedom : {1, 2, 7, 23}) {
    EXPECT_NEAR(two_sided_probability(0.0, freedom), 1.0, 1e-12);
    for (const double probability : {0.5, 0.01, 1e-5}) {
      const double size = two_sided_quantile(probability, freedom);
      EXPECT_NEAR(two_sided_probability(size, freedom) / probability, 1.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace raywalk::calibrate
