#include "build_lf/exposure/gain_significance.h"

#include <gtest/gtest.h>

#include "build_lf/exposure/patch_ratios.h"

namespace raywalk::build_lf {
namespace {

// In all channels `whole` everywhere, and `local` more in the first half of theta and less in the
// second.
PatchGains patches_of(double whole, double local) {
  PatchGains patches = PatchGains::Constant(whole + local);
  patches.bottomRows(kPatches / 2).setConstant(whole - local);
  return patches;
}

KeptGains kept_of(const PatchGains& gains, const PatchGains& black, const PatchGains& white,
                  bool is_measured = true) {
  std::array<bool, kPatches> measured{};
  measured.fill(is_measured);
  return keep_significant(gains, {black, white}, measured);
}

TEST(GainSignificanceTest, LargeGainsAreKept) {
  const auto gains = patches_of(0.1, 0.2);
  const KeptGains kept = kept_of(gains, gains, gains);
  EXPECT_NEAR(kept.whole[1], 0.1, 1e-9);
  ASSERT_TRUE(kept.patches.has_value());
  EXPECT_NEAR((*kept.patches)(0, 2), 0.2, 1e-9);
  EXPECT_NEAR((*kept.patches)(kPatches - 1, 2), -0.2, 1e-9);
}

TEST(GainSignificanceTest, WholeAndLocalGainsAreJudgedApart) {
  const auto gains = patches_of(0.1, 0.015);
  const KeptGains whole = kept_of(gains, gains, gains);
  EXPECT_NEAR(whole.whole[1], 0.1, 1e-9);
  EXPECT_FALSE(whole.patches.has_value());
  const auto varying = patches_of(0.005, 0.1);
  const KeptGains local = kept_of(varying, varying, varying);
  EXPECT_EQ(local.whole[1], 0.0);
  EXPECT_TRUE(local.patches.has_value());
}

// The same gains, where the halves of the ratios disagree about them.
TEST(GainSignificanceTest, UncertainGainsAreDropped) {
  const auto gains = patches_of(0.0, 0.1);
  EXPECT_FALSE(kept_of(gains, patches_of(0.0, 0.2), patches_of(0.0, 0.0)).patches.has_value());
  EXPECT_TRUE(kept_of(gains, patches_of(0.0, 0.11), patches_of(0.0, 0.09)).patches.has_value());
}

TEST(GainSignificanceTest, WithoutMeasuredPatchesNothingIsKept) {
  const auto gains = patches_of(0.1, 0.2);
  const KeptGains kept = kept_of(gains, gains, gains, false);
  EXPECT_EQ(kept.whole[0], 0.0);
  EXPECT_FALSE(kept.patches.has_value());
}

// A channel's patches: 0.3 in the first half of theta.
Eigen::VectorXd lens() { return patches_of(0.15, 0.15).col(0); }

// Sets a rectangle of patches.
void set(int first_theta, int last_theta, int first_phi, int last_phi, double value,
         Eigen::VectorXd* patches) {
  for (int theta = first_theta; theta <= last_theta; ++theta) {
    patches->segment(theta * kPatchesPhi + first_phi, last_phi - first_phi + 1).setConstant(value);
  }
}

// The largest difference in the ten rows around the horizon.
double off_around_horizon(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b)
      .reshaped(kPatchesPhi, kPatchesTheta)
      .middleRows(3, kPatchesPhi - 6)
      .cwiseAbs()
      .maxCoeff();
}

// At the poles all lenses meet, and their edges are not kept.
TEST(GainSpotsTest, PeopleVanishAndTheEdgesOfLensesStay) {
  EXPECT_EQ(off_around_horizon(without_spots(lens()), lens()), 0.0);
  Eigen::VectorXd person = lens();
  for (const int theta : {5, 20, 21, 27}) set(theta, theta, 7, 9, -1.0, &person);
  EXPECT_EQ(off_around_horizon(without_spots(person), lens()), 0.0);
}

// A chair below covers many of the narrow patches there.
TEST(GainSpotsTest, WhatStandsBelowVanishes) {
  Eigen::VectorXd chair = Eigen::VectorXd::Zero(kPatches);
  set(10, 15, kPatchesPhi - 2, kPatchesPhi - 1, 0.3, &chair);
  EXPECT_TRUE(without_spots(chair).isZero(0.0));
}

}  // namespace
}  // namespace raywalk::build_lf
