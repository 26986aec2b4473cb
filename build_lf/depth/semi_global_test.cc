#include "build_lf/depth/semi_global.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kCostSize{64, 32};
constexpr int kLayers = 32;
constexpr double kStep_per_m = 0.1;

size_t cost_pixel_at(int theta, int phi) {
  return static_cast<size_t>(theta * kCostSize.height + phi);
}

// A volume without information, in a single colour.
CostVolume blank_volume() {
  const size_t pixels = static_cast<size_t>(kCostSize.width * kCostSize.height);
  return {kCostSize,
          {kLayers, kStep_per_m},
          std::pmr::vector<std::uint8_t>(pixels * kLayers, 60),
          std::vector<std::uint8_t>(pixels, 100),
          std::vector<std::uint8_t>(pixels, 1)};
}

// Costs that rise from 0 at `layer` to at most 176.
void set_layer(CostVolume* volume, int theta, int phi, double layer) {
  for (int k = 0; k < kLayers; ++k) {
    volume->cost[cost_pixel_at(theta, phi) * kLayers + static_cast<size_t>(k)] =
        static_cast<std::uint8_t>(std::min(176.0, 8.0 * (k - layer) * (k - layer)));
  }
}

double layer_of(const InverseDistanceMap& map, int theta, int phi) {
  return map.omega[cost_pixel_at(theta, phi)] / kStep_per_m;
}

InverseDistanceMap regularised(const CostVolume& volume) {
  SemiGlobalScratch scratch;
  return regularise(volume, {}, &scratch);
}

// Two halves of the sphere with different distances and colours.
double step_layer(int theta) { return theta < kCostSize.width / 2 ? 5.3 : 20.7; }

CostVolume step_volume() {
  CostVolume volume = blank_volume();
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      set_layer(&volume, theta, phi, step_layer(theta));
      volume.luminance[cost_pixel_at(theta, phi)] = theta < kCostSize.width / 2 ? 50 : 150;
    }
  }
  return volume;
}

TEST(SemiGlobalTest, KeepsStepsAndInterpolatesBetweenLayers) {
  const auto map = regularised(step_volume());
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      ASSERT_NEAR(layer_of(map, theta, phi), step_layer(theta), 0.2) << theta << ' ' << phi;
      ASSERT_GT(map.confidence[cost_pixel_at(theta, phi)], 200);
    }
  }
}

TEST(SemiGlobalTest, SmoothsOutWeakOutliers) {
  CostVolume volume = step_volume();
  std::mt19937 random(1);
  for (size_t pixel = 0; pixel < volume.valid.size(); ++pixel) {
    if (random() % 5 != 0) continue;
    const size_t layer = random() % kLayers;
    for (size_t k = 0; k < kLayers; ++k) volume.cost[pixel * kLayers + k] = k == layer ? 0 : 30;
  }
  const auto map = regularised(volume);
  int right = 0;
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      right += std::fabs(layer_of(map, theta, phi) - step_layer(theta)) < 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(right, 0.97 * kCostSize.width * kCostSize.height);
}

TEST(SemiGlobalTest, CarriesDistancesThroughTheSeam) {
  // The blank pixels have the colour of those beyond the seam, not of those beside them.
  CostVolume volume = blank_volume();
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      if (theta >= 4) set_layer(&volume, theta, phi, theta < kCostSize.width / 2 ? 3.0 : 9.0);
      if (theta >= 4 && theta < kCostSize.width / 2)
        volume.luminance[cost_pixel_at(theta, phi)] = 250;
    }
  }
  const auto map = regularised(volume);
  for (int theta = 0; theta < 4; ++theta) {
    for (int phi = 4; phi < kCostSize.height - 4; ++phi) {
      ASSERT_NEAR(layer_of(map, theta, phi), 9.0, 0.5) << theta << ' ' << phi;
    }
  }
}

TEST(SemiGlobalTest, CarriesDistancesOverThePoles) {
  for (const bool zenith : {true, false}) {
    const auto row = [&](int from_pole) {
      return zenith ? from_pole : kCostSize.height - 1 - from_pole;
    };
    // Two opposite columns: one known up to the pole, the other known, and of another colour, from
    // five rows on.
    CostVolume volume = blank_volume();
    const int known = 5;
    const int open = known + kCostSize.width / 2;
    for (int i = 1; i < kCostSize.height / 2; ++i) set_layer(&volume, known, row(i), 9.0);
    for (int i = 5; i < kCostSize.height / 2; ++i) {
      set_layer(&volume, open, row(i), 3.0);
      volume.luminance[cost_pixel_at(open, row(i))] = 250;
    }
    const auto map = regularised(volume);
    for (int i = 0; i < 5; ++i) ASSERT_NEAR(layer_of(map, open, row(i)), 9.0, 0.5) << i;
  }
}

TEST(SemiGlobalTest, IsInvariantToRotation) {
  // The room turned by a third of a circle gives the map turned by as much.
  std::mt19937 random(3);
  std::vector<double> layers;
  for (int i = 0; i < kCostSize.width * kCostSize.height; ++i)
    layers.push_back(10.0 + random() % 8);
  const int turn = 21;
  CostVolume volume = blank_volume();
  CostVolume turned = blank_volume();
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      const double layer = layers[cost_pixel_at(theta / 8 * 8, phi / 8 * 8)];
      set_layer(&volume, theta, phi, layer);
      set_layer(&turned, (theta + turn) % kCostSize.width, phi, layer);
    }
  }
  const auto map = regularised(volume);
  const auto map_turned = regularised(turned);
  for (int theta = 0; theta < kCostSize.width; ++theta) {
    for (int phi = 0; phi < kCostSize.height; ++phi) {
      ASSERT_NEAR(layer_of(map, theta, phi),
                  layer_of(map_turned, (theta + turn) % kCostSize.width, phi), 0.1);
    }
  }
}

TEST(SemiGlobalTest, IsUnknownWhereNothingWasCompared) {
  CostVolume volume = step_volume();
  volume.valid[cost_pixel_at(7, 9)] = 0;
  const auto map = regularised(volume);
  EXPECT_EQ(map.confidence[cost_pixel_at(7, 9)], 0);
  EXPECT_GT(map.confidence[cost_pixel_at(8, 9)], 0);
}

TEST(SemiGlobalTest, SharpMinimaAreMoreConfident) {
  CostVolume vague = step_volume();
  for (auto& cost : vague.cost) cost = static_cast<std::uint8_t>(cost / 20);
  const auto sure = regularised(step_volume());
  const auto unsure = regularised(vague);
  EXPECT_GT(sure.confidence[cost_pixel_at(16, 16)], unsure.confidence[cost_pixel_at(16, 16)] + 50);
}

}  // namespace
}  // namespace raywalk::build_lf
