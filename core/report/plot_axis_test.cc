#include "core/report/plot_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raywalk {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Pointwise;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(PlotAxis, MapsTheRangeOntoThePixels) {
  const PlotAxis right({10.0, 20.0}, 100.0, 300.0, 5);
  EXPECT_DOUBLE_EQ(right.pixel(10.0), 100.0);
  EXPECT_DOUBLE_EQ(right.pixel(15.0), 200.0);
  EXPECT_DOUBLE_EQ(right.pixel(20.0), 300.0);
  const PlotAxis up({0.0, 1.0}, 400.0, 0.0, 5);
  EXPECT_DOUBLE_EQ(up.pixel(0.25), 300.0);
}

TEST(PlotAxis, TicksAreRoundNumbersInsideTheRange) {
  EXPECT_THAT(PlotAxis({45.0, 90.0}, 0.0, 1.0, 6).ticks(),
              ElementsAre(45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0));
  EXPECT_THAT(PlotAxis({-1.3, 1.7}, 0.0, 1.0, 5).ticks(),
              Pointwise(DoubleNear(1e-12), {-1.0, -0.5, 0.0, 0.5, 1.0, 1.5}));
  EXPECT_THAT(PlotAxis({0.0, 0.3}, 0.0, 1.0, 3).ticks(),
              Pointwise(DoubleNear(1e-12), {0.0, 0.1, 0.2, 0.3}));
}

TEST(PlotAxis, LabelsHaveTheDecimalsOfTheSpacing) {
  const PlotAxis tenths({0.0, 0.5}, 0.0, 1.0, 5);
  EXPECT_EQ(tenths.label(tenths.ticks()[3]), "0.3");
  EXPECT_EQ(tenths.label(0.0), "0.0");
  const PlotAxis whole({0.0, 5000.0}, 0.0, 1.0, 5);
  EXPECT_EQ(whole.label(3000.0), "3000");
  const PlotAxis fine({0.001, 0.002}, 0.0, 1.0, 5);
  EXPECT_EQ(fine.label(fine.ticks()[1]), "0.0012");
}

TEST(PlotAxis, HandlesAnInvalidRange) {
  for (const AxisRange range :
       {AxisRange{3.0, 3.0}, AxisRange{kInfinity, -kInfinity}, AxisRange{std::nan(""), 1.0},
        AxisRange{5.0, 2.0}, AxisRange{-1e308, 1e308}, AxisRange{1.0, 1.0 + 1e-15}}) {
    const PlotAxis axis(range, 0.0, 100.0, 5);
    EXPECT_LT(axis.range().min, axis.range().max);
    EXPECT_THAT(axis.ticks().size(), testing::AllOf(testing::Ge(2U), testing::Le(12U)));
    EXPECT_TRUE(std::isfinite(axis.pixel(axis.ticks().front())));
  }
}

TEST(PlotAxis, EqualFactorsAreEqualDistancesOnALogarithmicAxis) {
  const PlotAxis axis({0.5, 32.0}, 100.0, 700.0, 6, AxisScale::kLogarithmic);
  EXPECT_DOUBLE_EQ(axis.pixel(0.5), 100.0);
  EXPECT_NEAR(axis.pixel(1.0), 200.0, 1e-9);
  EXPECT_NEAR(axis.pixel(2.0), 300.0, 1e-9);
  EXPECT_NEAR(axis.pixel(32.0), 700.0, 1e-9);
  EXPECT_THAT(axis.ticks(), Pointwise(DoubleNear(1e-12), {0.5, 1.0, 2.0, 5.0, 10.0, 20.0}));
  EXPECT_EQ(axis.label(0.5), "0.5");
  EXPECT_EQ(axis.label(20.0), "20");
}

TEST(PlotAxis, LogarithmicTicksSuitNarrowAndWideRanges) {
  const PlotAxis wide({1e-3, 1e5}, 0.0, 1.0, 6, AxisScale::kLogarithmic);
  EXPECT_THAT(wide.ticks(), Pointwise(DoubleNear(1e-6), {1e-3, 1e-1, 1e1, 1e3, 1e5}));
  EXPECT_EQ(wide.label(wide.ticks()[0]), "1e-3");
  const PlotAxis narrow({1.1, 1.95}, 0.0, 1.0, 4, AxisScale::kLogarithmic);
  EXPECT_THAT(narrow.ticks(), Pointwise(DoubleNear(1e-12), {1.2, 1.4, 1.6, 1.8}));
  EXPECT_EQ(narrow.label(narrow.ticks()[0]), "1.2");
}

TEST(LogarithmicAxis, GivesEveryDecadeTheSameLength) {
  const PlotAxis axis({1e-6, 1e2}, 0.0, 800.0, 10, AxisScale::kLogarithmic);
  EXPECT_NEAR(axis.pixel(1e-6), 0.0, 1e-9);
  EXPECT_NEAR(axis.pixel(1e-2), 400.0, 1e-9);
  EXPECT_NEAR(axis.pixel(std::sqrt(10.0)), 650.0, 1e-9);
  EXPECT_NEAR(axis.pixel(1e2), 800.0, 1e-9);
}

TEST(LogarithmicAxis, HasTicksAtPowersOfTen) {
  const PlotAxis all({3e-3, 2e1}, 0.0, 1.0, 6, AxisScale::kLogarithmic);
  EXPECT_THAT(all.ticks(), Pointwise(DoubleNear(1e-12), {0.01, 0.1, 1.0, 10.0}));
  EXPECT_EQ(all.label(all.ticks()[0]), "1e-2");
  EXPECT_EQ(all.label(all.ticks()[2]), "1");
  EXPECT_EQ(all.label(all.ticks()[3]), "1e1");
  // Fourteen decades are too many for six ticks.
  const PlotAxis some({1e-6, 1e8}, 0.0, 1.0, 6, AxisScale::kLogarithmic);
  EXPECT_THAT(some.ticks().size(), testing::AllOf(testing::Ge(4U), testing::Le(8U)));
}

TEST(LogarithmicAxis, HandlesAnInvalidRange) {
  for (const AxisRange range : {AxisRange{3.0, 3.0}, AxisRange{kInfinity, -kInfinity},
                                AxisRange{-1.0, 1.0}, AxisRange{0.0, 0.0}, AxisRange{5.0, 2.0},
                                AxisRange{std::nan(""), 1.0}, AxisRange{5e-324, 1e308}}) {
    const PlotAxis axis(range, 0.0, 100.0, 5, AxisScale::kLogarithmic);
    EXPECT_GT(axis.range().min, 0.0);
    EXPECT_LT(axis.range().min, axis.range().max);
    EXPECT_THAT(axis.ticks().size(), testing::AllOf(testing::Ge(1U), testing::Le(12U)));
    EXPECT_TRUE(std::isfinite(axis.pixel(axis.ticks().front())));
  }
}

TEST(RoundedRange, GrowsToTheNextDecades) {
  const AxisRange range = rounded_range({3e-5, 20.0}, 5, AxisScale::kLogarithmic);
  EXPECT_NEAR(range.min, 1e-5, 1e-17);
  EXPECT_NEAR(range.max, 100.0, 1e-10);
}

TEST(RoundedRange, GrowsToTheNextTicks) {
  const AxisRange range = rounded_range({0.13, 0.97}, 5);
  EXPECT_NEAR(range.min, 0.1, 1e-12);
  EXPECT_NEAR(range.max, 1.0, 1e-12);
}

}  // namespace
}  // namespace raywalk
