// Samples near the poles, which are interpolated between columns further apart.
#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/polar_part.h"
#include "core/view/column_arrays.h"
#include "core/view/column_kernels.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

class PolarSamples : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, PolarSamples, testing::Values("generic", "avx2"), kernel_set_name);

constexpr PanoramaSize kPolarPanorama{4096, 2048};

TEST_P(PolarSamples, KeepTheirPositionBetweenColumnsFurtherApart) {
  constexpr int kPerRow = 4;
  const int rows = kPolarPanorama.height / kPerRow;
  const PolarPart part(kPolarPanorama);
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
    target.rays = part.layout_without();
    kernels_->place_shifted(shifted, 0, kPolarPanorama.height, target, apart.positions());
    target.rays = part.layout();
    SampleArrays closed_up(kPolarPanorama.height);
    kernels_->place_shifted(shifted, 0, kPolarPanorama.height, target, closed_up.positions());
    std::set<int> steps;
    for (size_t i = 0; i < static_cast<size_t>(kPolarPanorama.height); ++i) {
      const auto column = [&](std::int32_t offset) { return offset / 3 / kPolarPanorama.height; };
      const int upper = neighbours.left[i] / 3 % kPolarPanorama.height;
      ASSERT_EQ(apart.left[i] / 3 % kPolarPanorama.height, upper);
      ASSERT_EQ(apart.weight_lower[i], neighbours.weight_lower[i]);
      const int step = 1 << polar_doublings(target.rays.polar, upper, kPolarPanorama.height);
      steps.insert(step);
      ASSERT_EQ(column(apart.left[i]) % step, 0);
      ASSERT_EQ(column(apart.right[i]), (column(apart.left[i]) + step) % kPolarPanorama.width);
      const double here = column(apart.left[i]) + step * weight_of(apart.weight_right[i]) / 32768.0;
      const double there =
          column(neighbours.left[i]) + weight_of(neighbours.weight_right[i]) / 32768.0;
      ASSERT_NEAR(here, there, step / 32768.0) << "row " << i;
      // The polar part has the same pixels.
      for (const auto& [plain, polar] : {std::pair(apart.left[i], closed_up.left[i]),
                                         std::pair(apart.right[i], closed_up.right[i])}) {
        ASSERT_EQ(part.place_of(polar), part.place_of(plain)) << "row " << i;
        ASSERT_EQ(polar == plain, step == 1) << "row " << i;
      }
      ASSERT_EQ(closed_up.weight_right[i], apart.weight_right[i]);
      ASSERT_EQ(closed_up.weight_lower[i], apart.weight_lower[i]);
    }
    ASSERT_EQ(steps, (std::set<int>{1, 2, 4, 8, 16}));
  }
}

}  // namespace
}  // namespace raywalk
