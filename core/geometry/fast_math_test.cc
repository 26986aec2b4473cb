#include "core/geometry/fast_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace raywalk {
namespace {

constexpr double kBoundRad = 5.5e-7;  // as the header promises

double error_of(float y, float x) {
  return std::fabs(static_cast<double>(fast_atan2(y, x)) -
                   std::atan2(static_cast<double>(y), static_cast<double>(x)));
}

TEST(FastAtan2, StaysWithinItsBoundForArgumentsOfEverySize) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-37.0, 38.0);
  std::bernoulli_distribution negative(0.5);
  const auto argument = [&] {
    const double size = std::pow(10.0, exponent(random));
    return static_cast<float>(negative(random) ? -size : size);
  };
  for (int i = 0; i < 200000; ++i) {
    const float y = argument();
    const float x = argument();
    ASSERT_LT(error_of(y, x), kBoundRad) << y << ' ' << x;
  }
}

TEST(FastAtan2, StaysWithinItsBoundAllAroundTheCircle) {
  for (int i = 0; i < 400000; ++i) {
    const double angle = (i - 200000) * 1.5707963e-5;
    const auto y = static_cast<float>(std::sin(angle));
    const auto x = static_cast<float>(std::cos(angle));
    ASSERT_LT(error_of(y, x), kBoundRad) << angle;
  }
}

TEST(FastAtan2, MeetsTheAxes) {
  EXPECT_EQ(fast_atan2(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(fast_atan2(0.0f, 2.0f), 0.0f);
  for (const float size : {1e-30f, 1.0f, 1e30f}) {
    EXPECT_LT(error_of(0.0f, -size), kBoundRad);
    EXPECT_LT(error_of(size, 0.0f), kBoundRad);
    EXPECT_LT(error_of(-size, 0.0f), kBoundRad);
  }
}

TEST(FastAtan2, IsOddInItsFirstArgument) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> value(-1.0f, 1.0f);
  for (int i = 0; i < 10000; ++i) {
    const float y = value(random);
    const float x = value(random);
    ASSERT_EQ(fast_atan2(-y, x), -fast_atan2(y, x));
  }
}

}  // namespace
}  // namespace raywalk
