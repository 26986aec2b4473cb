#include "core/view/depth_layers.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace raywalk {
namespace {

TEST(DepthLayers, SpacingCoversTheRange) {
  for (const int count : {1, 4, 1000}) {
    const LayerSpacing layers = layer_spacing({0.25, 2.0}, count);
    EXPECT_EQ(layers.omega_min, 0.25f);
    EXPECT_NEAR(static_cast<double>(layers.omega_min) + count * static_cast<double>(layers.step),
                2.0, 1e-4);
  }
}

TEST(DepthLayers, SpacingOfASceneAtOneDistanceIsPositiveAndThere) {
  for (const double omega : {0.0, 1e-3, 1.0, 50.0}) {
    const LayerSpacing layers = layer_spacing({omega, omega}, 1);
    EXPECT_GT(layers.step, 0.0f);
    EXPECT_NEAR(layers.omega_min + 0.5 * layers.step, omega, 1e-6 * std::max(omega, 1.0));
  }
}

}  // namespace
}  // namespace raywalk
