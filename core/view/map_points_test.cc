#include "core/view/map_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raywalk {
namespace {

// A wall with a post before it and a pixel that is not known.
TEST(MapPoints, CoverEveryKnownPixelOnceAndJoinPixelsAwayFromSilhouettesOnly) {
  constexpr PanoramaSize kSize{64, 32};
  std::vector<float> inverse(static_cast<std::size_t>(kSize.width * kSize.height), 0.5f);
  const auto index = [&](int u, int v) {
    return static_cast<std::size_t>((u + kSize.width) % kSize.width * kSize.height + v);
  };
  for (int v = 8; v < 24; ++v) inverse[index(21, v)] = inverse[index(22, v)] = 2.0f;
  inverse[index(50, 10)] = -1.0f;
  const MapPoints points(inverse, kSize);
  std::vector<int> covered(inverse.size());
  for (const MapPoints::Column& column : points.columns) {
    for (std::size_t i = column.begin; i < column.end; ++i) {
      const double row = (0.5 - std::asin(double(points.sin_phi[i])) / kPi) * kSize.height - 0.5;
      const auto u = static_cast<int>(column.u), v = static_cast<int>(row + 0.01);
      const int beyond = column.pixels - 1;  // all of 4 x 4 pixels, or one
      for (int x = -beyond; x <= 2 * beyond; ++x) {
        for (int y = -beyond; y <= 2 * beyond; ++y) {
          ASSERT_EQ(points.inverse[i], inverse[index(u + x, v + y)]) << u << ", " << v;
          if (std::min(x, y) >= 0 && std::max(x, y) <= beyond) ++covered[index(u + x, v + y)];
        }
      }
    }
  }
  for (std::size_t i = 0; i < covered.size(); ++i) EXPECT_EQ(covered[i], inverse[i] > 0.0f ? 1 : 0);
  EXPECT_LT(2 * points.inverse.size(), inverse.size());
}

}  // namespace
}  // namespace raywalk
