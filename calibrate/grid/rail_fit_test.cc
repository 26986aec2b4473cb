#include "calibrate/grid/rail_fit.h"

#include <gtest/gtest.h>

#include <random>

namespace raywalk::calibrate {
namespace {

using P = RailParameter;
constexpr double kSpacing_m = 0.025;

struct Rail {
  RailFrame frame{.axis = LineAxis::kX, .middle_m = {0.1, 1.2, -0.5}, .half_length_m = 0.75};
  RailParameters parameters{};
  double jitter_m = 1e-3;
  double jitter_rad = 1.7e-3;
};

std::vector<RailSample> samples_of(const Rail& rail, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(random);
    const double y = normal(random);
    const double z = normal(random);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  std::vector<RailSample> samples;
  for (int i = 0; i < count; ++i) {
    const double rail_m = rail.frame.half_length_m * (2.0 * i / (count - 1) - 1.0);
    const Eigen::Vector3d turn = rail_rotation(rail.frame, rail.parameters.data(), rail_m);
    samples.push_back({.frame = i,
                       .rail_m = rail_m,
                       .position_m = rail_position(rail.frame, rail.parameters.data(), rail_m) +
                                     noise(rail.jitter_m),
                       .rotation = matrix_of(noise(rail.jitter_rad)) * matrix_of(turn),
                       .position_sigma_m = 1e-4,
                       .rotation_sigma_rad = 1e-4});
  }
  return samples;
}

std::string kept_name(const std::vector<RailModelScore>& models) {
  for (const RailModelScore& model : models) {
    if (model.kept) return model.name;
  }
  return "none";
}

TEST(RailFitTest, AStraightRailIsRecovered) {
  Rail rail;
  rail.parameters = {0.012, -0.02, 0.006, 0.03, -0.02, 0.01, 0.14, -0.02};
  const std::vector<RailSample> samples = samples_of(rail, 61, 1);
  const RailFit fit = fit_rail(rail.frame, samples, kSpacing_m);
  EXPECT_EQ(kept_name(fit.position_models), "straight");
  EXPECT_EQ(kept_name(fit.rotation_models), "rigid");
  // A mean of 61 to within 4 sigma; slopes have the lever 0.75 m / sqrt(3).
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(fit.parameters[i], rail.parameters[i], 5e-4);
  for (size_t i = 3; i < 5; ++i) EXPECT_NEAR(fit.parameters[i], rail.parameters[i], 1.2e-3);
  for (size_t i = 5; i < 8; ++i) EXPECT_NEAR(fit.parameters[i], rail.parameters[i], 9e-4);
  EXPECT_NEAR(fit.jitter.along_m, 1e-3, 4e-4);
  EXPECT_NEAR(fit.jitter.across_m, 1e-3, 3e-4);
  EXPECT_NEAR(fit.jitter.rotation_rad, 1.7e-3, 5e-4);
}

// Far from the plan, where cosines are far from 1 and rotations do not commute.
TEST(RailFitTest, AFarRotatedRailIsRecoveredExactly) {
  for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
    Rail rail;
    rail.frame.axis = axis;
    rail.jitter_m = rail.jitter_rad = 0.0;
    rail.parameters = {0.3, -0.2, 0.5, 0.25, -0.2, 0.4, -0.9, 0.3, 0.004, -0.003};
    const RailFit fit = fit_rail(rail.frame, samples_of(rail, 31, 1), kSpacing_m);
    for (size_t i = 0; i < rail.parameters.size(); ++i) {
      EXPECT_NEAR(fit.parameters[i], rail.parameters[i], 1e-8) << i;
    }
  }
}

TEST(RailFitTest, SelectsTheTrueModel) {
  struct Case {
    size_t parameter;
    double value;
    const char* position;
    const char* rotation;
  };
  for (const Case& made :
       {Case{P::kBow, 3e-3, "bow", "rigid"}, Case{P::kSBow + 1, 3e-3, "S-bow", "rigid"},
        Case{P::kTwist, 6e-3, "straight", "twist"},
        Case{P::kCurvedTwist + 2, 6e-3, "straight", "curved twist"}}) {
    Rail rail;
    rail.parameters[made.parameter] = made.value;
    const RailFit fit = fit_rail(rail.frame, samples_of(rail, 61, 3), kSpacing_m);
    EXPECT_EQ(kept_name(fit.position_models), made.position);
    EXPECT_EQ(kept_name(fit.rotation_models), made.rotation);
    EXPECT_NEAR(fit.parameters[made.parameter], made.value, 0.3 * made.value);
    EXPECT_TRUE(fit.kept[made.parameter]);
  }
}

// Samples left out of a fit have larger residuals than those in it.
TEST(RailFitTest, CrossValidationShowsOverfitting) {
  Rail rail;
  const RailFit fit = fit_rail(rail.frame, samples_of(rail, 14, 4), kSpacing_m);
  ASSERT_EQ(fit.position_models.size(), 3U);
  for (const RailModelScore& model : fit.position_models) EXPECT_GT(model.left_out, model.residual);
  EXPECT_LT(fit.position_models[2].residual, fit.position_models[0].residual);
}

TEST(RailFitTest, WrongPosesAreRejectedAndDoNotCount) {
  Rail rail;
  rail.parameters[P::kHeading] = 0.02;
  std::vector<RailSample> samples = samples_of(rail, 41, 5);
  for (const size_t wrong : {0U, 1U, 2U, 3U}) samples[wrong].position_m.z() += 0.05;
  const RailFit fit = fit_rail(rail.frame, samples, kSpacing_m);
  for (size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(fit.rejected[i], i < 4) << i;
  EXPECT_NEAR(fit.parameters[P::kHeading], 0.02, 1.5e-3);
}

TEST(RailFitTest, AWellSupportedBumpIsKept) {
  Rail rail;
  std::vector<RailSample> samples = samples_of(rail, 41, 6);
  samples[20].position_m.y() += 0.01;
  EXPECT_TRUE(fit_rail(rail.frame, samples, kSpacing_m).rejected[20]);
  samples[20].well_supported = true;
  EXPECT_FALSE(fit_rail(rail.frame, samples, kSpacing_m).rejected[20]);
  samples[20].position_m.y() += 0.02;
  EXPECT_TRUE(fit_rail(rail.frame, samples, kSpacing_m).rejected[20]);
}

TEST(RailFitTest, FewSamplesGiveTheRigidModel) {
  Rail rail;
  rail.jitter_m = rail.jitter_rad = 0.0;
  rail.parameters = {0.01, 0.02, 0.03, 0.01, 0.0, 0.1, 0.0, 0.0};
  const std::vector<RailSample> two = samples_of(rail, 2, 7);
  for (const size_t count : {1U, 2U}) {
    const RailFit fit = fit_rail(rail.frame, std::span(two).first(count), kSpacing_m);
    EXPECT_EQ(fit.parameters[P::kHeading], 0.0);
    EXPECT_NEAR(fit.parameters[P::kRotation], 0.1, 1e-9);
    EXPECT_EQ(kept_name(fit.position_models), "straight");
    for (const double parameter : fit.parameters) EXPECT_TRUE(std::isfinite(parameter));
  }
}

}  // namespace
}  // namespace raywalk::calibrate
