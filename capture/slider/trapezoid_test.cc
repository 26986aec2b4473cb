#include "capture/slider/trapezoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace raywalk::capture {
namespace {

TEST(TrapezoidTest, LongMoveCruises) {
  // Ramps of 0.5 s and 25 mm each, 50 mm at 100 mm/s between them.
  const Trapezoid way(100.0, {100.0, 200.0});
  EXPECT_DOUBLE_EQ(way.duration_ms(), 1500.0);
  EXPECT_DOUBLE_EQ(way.travelled_mm(500.0), 25.0);
  EXPECT_DOUBLE_EQ(way.travelled_mm(1000.0), 75.0);
  EXPECT_DOUBLE_EQ(way.speed_mm_s(750.0), 100.0);
}

TEST(TrapezoidTest, ShortMoveHasNoCruise) {
  const Trapezoid way(2.0, {100.0, 200.0});
  EXPECT_DOUBLE_EQ(way.duration_ms(), 200.0);  // 2 sqrt(d/a)
  EXPECT_DOUBLE_EQ(way.travelled_mm(100.0), 1.0);
  EXPECT_DOUBLE_EQ(way.speed_mm_s(100.0), 20.0);
}

TEST(TrapezoidTest, ZeroDistanceTakesNoTime) {
  const Trapezoid way(0.0, {100.0, 200.0});
  EXPECT_EQ(way.duration_ms(), 0.0);
  EXPECT_EQ(way.travelled_mm(10.0), 0.0);
  EXPECT_EQ(way.speed_mm_s(0.0), 0.0);
}

TEST(TrapezoidTest, StoppingTakesSpeedOverAcceleration) {
  EXPECT_DOUBLE_EQ(stopping_ms({100.0, 200.0}), 500.0);
}

// Speed is the derivative of the distance, never above the top speed; the move ends at the
// distance.
TEST(TrapezoidTest, HoldsOverAllScales) {
  std::mt19937_64 random(3);
  const auto any = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(random));
  };
  for (int i = 0; i < 2000; ++i) {
    const MotionProfile profile{any(1e-3, 1e4), any(1e-3, 1e5)};
    const double distance = any(1e-4, 1e5);
    const Trapezoid way(distance, profile);
    const double duration = way.duration_ms();
    EXPECT_NEAR(way.travelled_mm(duration * (1.0 - 1e-12)), distance, 1e-9 * distance);
    const double t = duration * std::uniform_real_distribution(0.01, 0.99)(random);
    const double h = duration * 1e-6;
    const double slope = (way.travelled_mm(t + h) - way.travelled_mm(t - h)) / (2.0 * h) * 1e3;
    EXPECT_NEAR(slope, way.speed_mm_s(t), 1e-3 * distance / duration * 1e3);
    EXPECT_LE(way.speed_mm_s(t), profile.speed_mm_s * (1.0 + 1e-12));
  }
}

}  // namespace
}  // namespace raywalk::capture
