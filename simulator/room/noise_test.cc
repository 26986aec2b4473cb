#include "simulator/room/noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/room/hash_random.h"
#include "simulator/room/surface.h"

namespace raywalk::simulator {
namespace {

TEST(HashRandomTest, BranchesDoNotDependOnPreviousDraws) {
  HashRandom a(1), b(1);
  a.bits();
  EXPECT_EQ(a.branch(3).bits(), b.branch(3).bits());
  EXPECT_NE(b.branch(3).bits(), b.branch(4).bits());
}

// Known values keep rooms the same from release to release.
TEST(HashRandomTest, HashIsSplitMix64) {
  EXPECT_EQ(hash_bits(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(hash_bits(0x9e3779b97f4a7c15ULL), 0x6e789e6aa1b965f4ULL);
}

TEST(NoiseTest, OctavesBeyondTheNyquistLimitFadeOut) {
  const Octaves octaves{1.0F, 6, 0.7F};
  double sharp = 0.0, blurred = 0.0, constant = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector2f here(0.173F * static_cast<float>(i), 0.41F);
    const Eigen::Vector2f near = here + Eigen::Vector2f(0.03F, 0.0F);
    sharp +=
        std::abs(fractal_noise(here, octaves, 0.001F, 1) - fractal_noise(near, octaves, 0.001F, 1));
    blurred +=
        std::abs(fractal_noise(here, octaves, 0.4F, 1) - fractal_noise(near, octaves, 0.4F, 1));
    constant += std::abs(fractal_noise(here, octaves, 1.1F, 1));
  }
  EXPECT_LT(blurred, 0.3 * sharp);
  EXPECT_EQ(constant, 0.0);
}

TEST(NoiseTest, StripeKeepsItsAreaBelowPixelSize) {
  for (const float footprint : {0.01F, 0.1F, 0.5F, 2.0F}) {
    double area = 0.0;
    for (int i = -3000; i < 3000; ++i) {
      area += 0.001 * soft_stripe(0.001F * static_cast<float>(i), 0.1F, footprint);
    }
    EXPECT_NEAR(area, 0.2, 0.003) << footprint;
  }
}

TEST(SurfaceTest, ReflectancesArePositiveAndBounded) {
  HashRandom random(4);
  for (int pattern = 0; pattern <= static_cast<int>(Pattern::kPainting); ++pattern) {
    Surface surface;
    surface.pattern = static_cast<Pattern>(pattern);
    surface.base = Color(0.6F, 0.5F, 0.4F);
    surface.accent = Color(0.2F, 0.3F, 0.4F);
    surface.seed = 9;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2f at(static_cast<float>(random.uniform(-20, 20)),
                               static_cast<float>(random.uniform(-20, 20)));
      const Color albedo =
          albedo_at(surface, at, static_cast<float>(1e-4 * std::pow(1e4, random.uniform())));
      EXPECT_GT(albedo.minCoeff(), 0.0F) << pattern;
      EXPECT_LT(albedo.maxCoeff(), 1.3F) << pattern;
    }
  }
}

}  // namespace
}  // namespace raywalk::simulator
