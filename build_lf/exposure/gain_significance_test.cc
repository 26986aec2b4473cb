#include "build_lf/exposure/gain_significance.h"

#include <gtest/gtest.h>

#include "build_lf/exposure/patch_ratios.h"

namespace raywalk::build_lf {
namespace {

// `whole` everywhere, and `local` more in the first half of theta and less in the second.
std::vector<double> patches_of(double whole, double local) {
  std::vector<double> patches;
  for (int patch = 0; patch < kPatches; ++patch) {
    patches.push_back(whole + (patch < kPatches / 2 ? local : -local));
  }
  return patches;
}

KeptGains kept_of(const std::vector<double>& gains, const std::vector<double>& black,
                  const std::vector<double>& white) {
  std::array<bool, kPatches> measured{};
  measured.fill(true);
  return keep_significant({gains, gains, gains},
                          {PatchGains{black, black, black}, PatchGains{white, white, white}},
                          measured);
}

TEST(GainSignificanceTest, LargeGainsAreKept) {
  const auto gains = patches_of(0.1, 0.2);
  const KeptGains kept = kept_of(gains, gains, gains);
  EXPECT_NEAR(kept.whole[1], 0.1, 1e-9);
  ASSERT_TRUE(kept.local);
  EXPECT_NEAR(kept.patches[2][0], 0.2, 1e-9);
  EXPECT_NEAR(kept.patches[2][kPatches - 1], -0.2, 1e-9);
}

TEST(GainSignificanceTest, SmallGainsAreDropped) {
  const auto gains = patches_of(0.005, 0.015);
  const KeptGains kept = kept_of(gains, gains, gains);
  EXPECT_EQ(kept.whole[0], 0.0);
  EXPECT_FALSE(kept.local);
}

TEST(GainSignificanceTest, WholeAndLocalGainsAreJudgedApart) {
  const auto gains = patches_of(0.1, 0.01);
  const KeptGains whole = kept_of(gains, gains, gains);
  EXPECT_NEAR(whole.whole[1], 0.1, 1e-9);
  EXPECT_FALSE(whole.local);
  const auto varying = patches_of(0.002, 0.1);
  const KeptGains local = kept_of(varying, varying, varying);
  EXPECT_EQ(local.whole[1], 0.0);
  EXPECT_TRUE(local.local);
}

// The same gains, where the halves of the ratios disagree about them.
TEST(GainSignificanceTest, UncertainGainsAreDropped) {
  const auto gains = patches_of(0.0, 0.1);
  EXPECT_FALSE(kept_of(gains, patches_of(0.0, 0.2), patches_of(0.0, 0.0)).local);
  EXPECT_TRUE(kept_of(gains, patches_of(0.0, 0.11), patches_of(0.0, 0.09)).local);
}

TEST(GainSignificanceTest, WithoutMeasuredPatchesNothingIsKept) {
  const auto gains = patches_of(0.1, 0.2);
  const KeptGains kept = keep_significant(
      {gains, gains, gains}, {PatchGains{gains, gains, gains}, PatchGains{gains, gains, gains}},
      std::array<bool, kPatches>{});
  EXPECT_EQ(kept.whole[0], 0.0);
  EXPECT_FALSE(kept.local);
}

// Patches of the ten rows around the horizon.
std::vector<double> around_horizon(const std::vector<double>& patches) {
  std::vector<double> chosen;
  for (int patch = 0; patch < kPatches; ++patch) {
    const int phi = patch % kPatchesPhi;
    if (phi >= 3 && phi < kPatchesPhi - 3) chosen.push_back(patches[static_cast<size_t>(patch)]);
  }
  return chosen;
}

// At the poles all lenses meet, and their edges are not kept.
TEST(GainSpotsTest, PeopleVanishAndTheEdgesOfLensesStay) {
  std::vector<double> lens(kPatches, 0.0);
  for (int patch = 0; patch < kPatches / 2; ++patch) lens[static_cast<size_t>(patch)] = 0.3;
  EXPECT_EQ(around_horizon(without_spots(lens)), around_horizon(lens));
  std::vector<double> person = lens;
  for (const int theta : {5, 20, 21, 27}) {
    for (int phi = 7; phi < 10; ++phi) {
      person[static_cast<size_t>(theta * kPatchesPhi + phi)] = -1.0;
    }
  }
  EXPECT_EQ(around_horizon(without_spots(person)), around_horizon(lens));
}

// A chair below covers many of the narrow patches there.
TEST(GainSpotsTest, WhatStandsBelowVanishes) {
  std::vector<double> chair(kPatches, 0.0);
  for (int theta = 10; theta < 16; ++theta) {
    for (const int phi : {kPatchesPhi - 2, kPatchesPhi - 1}) {
      chair[static_cast<size_t>(theta * kPatchesPhi + phi)] = 0.3;
    }
  }
  EXPECT_EQ(without_spots(chair), std::vector<double>(kPatches, 0.0));
}

}  // namespace
}  // namespace raywalk::build_lf
