#include <gtest/gtest.h>

#include <cmath>

#include "build_lf/refine/developed_station.h"

namespace raywalk::build_lf {
namespace {

constexpr float kNear = 1.0f, kFar = 0.2f;
constexpr PanoramaSize kCoarse{128, 64};

// A disc before a wall, `turn` of a circle around the panorama.
template <typename Place>
OmegaMap disc(PanoramaSize size, const Place& turn) {
  OmegaMap map(size);
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) {
      double across = (u + 0.5) / size.width - turn;
      across -= std::round(across);
      const double down = ((v + 0.5) / size.height - 0.5) / 2;
      map.at(u, v) = std::hypot(across, down) < 0.11 ? kNear : kFar;
    }
  }
  return map;
}

int wrong_pixels(const OmegaMap& map, const OmegaMap& truth) {
  int wrong = 0;
  for (std::size_t i = 0; i < map.values().size(); ++i) {
    wrong += std::fabs(map.values()[i] - truth.values()[i]) > 0.01f ? 1 : 0;
  }
  return wrong;
}

TEST(FineMapTest, StepsAreNoStairs) {
  for (const double turn : {0.3, 0.501, 0.0}) {  // the last across the seam
    for (const int factor : {2, 4}) {
      const OmegaMap truth = disc({128 * factor, 64 * factor}, turn), map = disc(kCoarse, turn);
      const int stairs = wrong_pixels(resized(map, 128 * factor), truth);
      EXPECT_LT(wrong_pixels(enlarged(map, 128 * factor), truth), stairs * 9 / 10)
          << turn << " " << factor;
    }
  }
}

TEST(FineMapTest, ALineOfAPixelStays) {
  OmegaMap map = disc(kCoarse, 0.3);
  for (int v = 0; v < kCoarse.height; ++v) map.at(100, v) = kNear;
  for (const int factor : {1, 2, 3, 8}) {
    const OmegaMap fine = enlarged(map, 128 * factor);
    for (int i = 0; i < factor; ++i) {
      EXPECT_EQ(fine.at(100 * factor + i, 20 * factor), kNear) << factor;
    }
    EXPECT_EQ(fine.at(100 * factor - 1, 20 * factor), kFar);
    EXPECT_EQ(fine.at(101 * factor, 20 * factor), kFar);
  }
}

TEST(FineMapTest, UnknownStaysUnknown) {
  OmegaMap map = disc(kCoarse, 0.3);
  for (int u = 80; u < 90; ++u) map.at(u, 10) = map.at(u, 11) = -1.0f;
  const OmegaMap fine = enlarged(map, 256);
  EXPECT_LT(fine.at(170, 22), 0.0f);
  EXPECT_EQ(fine.at(170, 30), kFar);
}

}  // namespace
}  // namespace raywalk::build_lf
