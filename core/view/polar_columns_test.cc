// Samples near the poles, which are interpolated between columns further apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/view/column_arrays.h"
#include "core/view/column_kernels.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

// Distance between neighbouring columns at a row's lower edge, in row heights: the largest distance
// that a sample between this row and the next one meets.
double column_distance(int row, PanoramaSize size) {
  const double from_pole = (std::min(row, size.height - 2 - row) + 1.0) / size.height * kPi;
  return std::sin(from_pole) * (kTwoPi / size.width) / (kPi / size.height);
}

TEST(PolarColumns, AreAsFarApartAsHalfARowsHeightAllows) {
  for (const int width : {16, 64, 512, 4096, 6000, 8192, 32768}) {
    const PanoramaSize size{width, width / 2};
    const PolarColumns polar = polar_columns(size);
    for (int row = 0; row + 1 < size.height; ++row) {
      const int step = 1 << polar_doublings(polar, row, size.height);
      const bool could_be_wider = step < 16 && width % (2 * step) == 0;
      if (could_be_wider) {
        ASSERT_GT(2 * step * column_distance(row, size), 0.5 - 1e-9) << width << " row " << row;
      }
      if (step == 1) continue;
      ASSERT_LE(step * column_distance(row, size), 0.5 + 1e-9) << width << " row " << row;
      ASSERT_EQ(width % step, 0);
    }
    const int middle = polar_doublings(polar, size.height / 2 - 1, size.height);
    EXPECT_EQ(middle, 0);
    if (width >= 4096 && width % 16 == 0) {
      EXPECT_EQ(1 << polar_doublings(polar, 0, size.height), 16);
    }
  }
}

TEST(PolarColumns, AreNeighboursWhereTheWidthCannotBeHalved) {
  const PolarColumns polar = polar_columns({4100, 2050});
  EXPECT_EQ(1 << polar_doublings(polar, 0, 2050), 4);
  const PolarColumns odd = polar_columns({1025, 512});
  EXPECT_EQ(polar_doublings(odd, 0, 512), 0);
}

class PolarSamples : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, PolarSamples, testing::Values("generic", "avx2"), kernel_set_name);

constexpr PanoramaSize kPolarPanorama{4096, 2048};

TEST_P(PolarSamples, KeepTheirPositionBetweenColumnsFurtherApart) {
  constexpr int kPerRow = 4;
  const int rows = kPolarPanorama.height / kPerRow;
  for (int repeat = 0; repeat < 20; ++repeat) {
    ShiftArrays shifts(rows);
    for (int i = 0; i < rows; ++i) {
      shifts.u[static_cast<size_t>(i)] = static_cast<float>(random_.uniform(-2000.0, 2000.0));
      shifts.v[static_cast<size_t>(i)] = static_cast<float>(random_.uniform(-30.0, 30.0));
    }
    ColumnTarget target{kPolarPanorama.width, kPolarPanorama.height, 4090, 0.625f};
    const ShiftedRows shifted = shifts.from(0, rows, kPerRow);
    SampleArrays neighbours(kPolarPanorama.height), apart(kPolarPanorama.height);
    kernels_->place_shifted(shifted, 0, kPolarPanorama.height, target, neighbours.positions());
    target.polar = polar_columns(kPolarPanorama);
    kernels_->place_shifted(shifted, 0, kPolarPanorama.height, target, apart.positions());
    std::set<int> steps;
    for (size_t i = 0; i < static_cast<size_t>(kPolarPanorama.height); ++i) {
      const auto column = [&](std::int32_t offset) { return offset / 3 / kPolarPanorama.height; };
      const int upper = neighbours.left[i] / 3 % kPolarPanorama.height;
      ASSERT_EQ(apart.left[i] / 3 % kPolarPanorama.height, upper);
      ASSERT_EQ(apart.weight_lower[i], neighbours.weight_lower[i]);
      const int step = 1 << polar_doublings(target.polar, upper, kPolarPanorama.height);
      steps.insert(step);
      ASSERT_EQ(column(apart.left[i]) % step, 0);
      ASSERT_EQ(column(apart.right[i]), (column(apart.left[i]) + step) % kPolarPanorama.width);
      const double here = column(apart.left[i]) + step * weight_of(apart.weight_right[i]) / 32768.0;
      const double there =
          column(neighbours.left[i]) + weight_of(neighbours.weight_right[i]) / 32768.0;
      ASSERT_NEAR(here, there, step / 32768.0) << "row " << i;
    }
    ASSERT_EQ(steps, (std::set<int>{1, 2, 4, 8, 16}));
  }
}

}  // namespace
}  // namespace raywalk
