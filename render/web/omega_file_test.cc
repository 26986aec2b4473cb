#include "render/web/omega_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/web/test_omega.h"

namespace raywalk::render {
namespace {

TEST(OmegaFile, HoldsFallsAndRisesOverTheWholeRange) {
  OmegaMap map({16, 8});
  for (int theta = 0; theta < 16; ++theta) {
    for (int row = 0; row < 8; ++row) map.at(theta, row) = (theta + row) % 2 == 0 ? 0.0F : 2.0F;
  }
  map.at(3, 4) = 5.0F;  // too near, which becomes the nearest
  const double step_per_m = 2.0 / kLargestOmegaValue;
  const OmegaMap read = decoded_omega(encode_omega(map, step_per_m), 16, step_per_m);
  map.at(3, 4) = 2.0F;
  EXPECT_TRUE(std::ranges::equal(read.values(), map.values()));
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
