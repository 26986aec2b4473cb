#include "render/web/omega_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/web/test_omega.h"

namespace raywalk::render {
namespace {

OmegaMap map_of(float (*omega)(int theta, int row)) {
  OmegaMap map({16, 8});
  for (int theta = 0; theta < 16; ++theta) {
    for (int row = 0; row < 8; ++row) map.at(theta, row) = omega(theta, row);
  }
  return map;
}

TEST(OmegaFile, HoldsEveryPixelInItsPlace) {
  const OmegaMap map = map_of([](int theta, int row) {
    return static_cast<float>(theta + 16 * row) / 100.0F;  // no two alike
  });
  const double step_per_m = 1.27 / kLargestOmegaValue;
  const OmegaMap read = decoded_omega(encode_omega(map, step_per_m), 16, step_per_m);
  for (int theta = 0; theta < 16; ++theta) {
    for (int row = 0; row < 8; ++row) {
      EXPECT_NEAR(read.at(theta, row), map.at(theta, row), 0.51 * step_per_m)
          << theta << ',' << row;
    }
  }
}

TEST(OmegaFile, HoldsFallsAndRisesOverTheWholeRange) {
  const OmegaMap map =
      map_of([](int theta, int row) { return (theta + row) % 2 == 0 ? 0.0F : 2.0F; });
  const double step_per_m = 2.0 / kLargestOmegaValue;
  const OmegaMap read = decoded_omega(encode_omega(map, step_per_m), 16, step_per_m);
  EXPECT_EQ(read.at(0, 0), 0.0F);
  EXPECT_EQ(read.at(0, 1), 2.0F);
  EXPECT_EQ(read.at(0, 2), 0.0F);
  EXPECT_EQ(read.at(15, 7), 0.0F);
}

TEST(OmegaFile, WhatIsTooNearBecomesTheNearest) {
  const OmegaMap map = map_of([](int, int) { return 5.0F; });
  const double step_per_m = 1.0 / kLargestOmegaValue;
  EXPECT_EQ(decoded_omega(encode_omega(map, step_per_m), 16, step_per_m).at(3, 3), 1.0F);
}

TEST(OmegaFile, SmoothDistancesAreFewBytes) {
  OmegaMap map({512, 256});
  for (int theta = 0; theta < 512; ++theta) {
    for (int row = 0; row < 256; ++row) {
      map.at(theta, row) = static_cast<float>(std::sin(0.01 * row) * std::cos(0.01 * theta) + 1.0);
    }
  }
  EXPECT_LT(encode_omega(map, 2.0 / kLargestOmegaValue).size(), map.values().size_bytes() / 6);
}

}  // namespace
}  // namespace raywalk::render
