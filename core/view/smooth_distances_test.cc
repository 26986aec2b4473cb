#include "core/view/smooth_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kMapSize{256, 128};

// Trust in a map of the given confidences.
MapTrust trust_in(const std::function<std::uint8_t(int u, int v)>& confidence) {
  SyntheticRoomSpec spec;
  spec.width = 16;
  spec.distance_width = kMapSize.width;
  spec.spacing_m = 0.5;
  spec.distance_every = 100;
  spec.stored_confidence = confidence;
  const TestRoom room(spec);
  return {room.room().distances(0), 0};
}

// In column `u`, at the horizon, of a view from the map's station.
float trust_at(const MapTrust& map, double u) {
  float trust = 0.0f, far = 0.0f;
  map.find_most(theta_of_column(u, kMapSize.width), Latitudes(1), {}, &far, &trust);
  return trust;
}

TEST(MapTrust, FallsSmoothlyToNothingWhereMostPixelsAreUnreliable) {
  const auto few = [](int u, int v) { return u % 4 == 0 && v % 4 == 0 ? 10 : 200; };
  EXPECT_TRUE(trust_in(few).everywhere()) << "a few change nothing";
  const MapTrust trust = trust_in([](int u, int) { return u < kMapSize.width / 2 ? 255 : 70; });
  EXPECT_FALSE(trust.everywhere());
  EXPECT_EQ(trust_at(trust, 64.0), 1.0f);
  EXPECT_LT(trust_at(trust, 192.0), 0.01f);
  for (int u = 0; u < kMapSize.width; ++u) {
    const float step = trust_at(trust, u) - trust_at(trust, u + 1.0);
    EXPECT_LT(std::fabs(step), 0.2f) << u;
  }
}

class DoubtedView : public testing::Test {
 protected:
  // Smooth distances of a view that is not to be relied on.
  void compute() {
    static const MapTrust trust = trust_in([](int, int) { return 64; });
    const std::vector<TrustedMap> maps{{.trust = &trust}};
    smooth_.compute(omega_, kMapSize, EyeCircle(), maps);
  }
  std::vector<float> column(int theta) const {
    std::vector<float> omega(128, 100.0f);
    EXPECT_NE(smooth_.trust(theta), nullptr);
    smooth_.smooth(theta, omega);
    return omega;
  }
  std::vector<float> omega_ = std::vector<float>(static_cast<size_t>(256 * 128), 0.5f);
  SmoothDistances smooth_;
};

TEST_F(DoubtedView, SinglePixelsThatDifferDoNotShow) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anything(-1.0f, 20.0f);
  for (float& omega : omega_) {
    if (random() % 3 == 0) omega = anything(random);
  }
  compute();
  for (int theta = 0; theta < kMapSize.width; theta += 5) {
    for (const float omega : column(theta)) EXPECT_NEAR(omega, 0.5f, 0.05f);
  }
}

TEST_F(DoubtedView, GapsTakeTheDistanceAround) {
  for (int theta = -30; theta < 30; ++theta) {
    const auto first = static_cast<size_t>((theta + 256) % 256) * 128;
    std::fill_n(omega_.begin() + static_cast<std::ptrdiff_t>(first) + 40, 60, -1.0f);
  }
  compute();
  for (const int theta : {250, 0, 10}) {
    for (const float omega : column(theta)) EXPECT_NEAR(omega, 0.5f, 1e-3f);
  }
}

TEST_F(DoubtedView, WithoutAnyDistanceEverythingIsFar) {
  std::ranges::fill(omega_, -1.0f);
  compute();
  for (const float omega : column(9)) EXPECT_EQ(omega, 0.0f);
}

TEST(SmoothDistances, AreFiniteWhateverTheDistancesInViewsOfAnySize) {
  const MapTrust trust = trust_in([](int u, int) { return u % 3 == 0 ? 200 : 64; });
  const std::vector<TrustedMap> maps{{.trust = &trust, .position_m = {1.0, 2.0, 3.0}}};
  std::mt19937 random(3);
  for (const int height : {1, 2, 3, 5, 125}) {
    const auto rows = static_cast<size_t>(height);
    std::vector<float> omega(2 * rows * rows);
    for (float& each : omega) each = std::array{-1.0f, 0.0f, 1e-9f, 1e9f}[random() % 4];
    SmoothDistances smooth;
    smooth.compute(omega, {2 * height, height}, EyeCircle(), maps);
    for (int theta = 0; theta < 2 * height; ++theta) {
      std::vector<float> column(rows, 1e9f);
      EXPECT_NE(smooth.trust(theta), nullptr);
      smooth.smooth(theta, column);
      for (const float each : column) EXPECT_TRUE(each >= 0.0f && each <= 1.001e9f) << height;
    }
  }
}

}  // namespace
}  // namespace raywalk
