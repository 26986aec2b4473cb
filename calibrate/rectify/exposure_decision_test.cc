#include "calibrate/rectify/exposure_decision.h"

#include <gtest/gtest.h>

#include <random>

namespace raywalk::calibrate {
namespace {

constexpr int kOnLine = 9;
constexpr int kPictures = 2 * kOnLine;

std::vector<PictureLine> two_lines() {
  std::vector<PictureLine> lines(2);
  for (int i = 0; i < kPictures; ++i) {
    lines[static_cast<std::size_t>(i / kOnLine)].pictures.push_back(i);
    lines[static_cast<std::size_t>(i / kOnLine)].along_m.push_back(0.1 * (i % kOnLine));
  }
  return lines;
}

// The truth measured with independent errors of 0.001.
UncertainLight measured(const Eigen::VectorXd& truth, unsigned seed) {
  constexpr double kError = 0.001;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, kError);
  UncertainLight light{.value = truth,
                       .errors = kError * Eigen::MatrixXd::Identity(kPictures, kPictures),
                       .freedom = 23};
  for (double& value : light.value) value += noise(random);
  return light;
}

TEST(ExposureDecisionTest, EqualExposuresAreLeftExactlyAlone) {
  int changed = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const auto decision =
        decide_exposures(measured(Eigen::VectorXd::Zero(kPictures), seed), two_lines());
    changed += decision.correction.isZero(0.0) ? 0 : 1;
  }
  // 1 % of captures, by the level of significance.
  EXPECT_LE(changed, 3);
}

TEST(ExposureDecisionTest, OneExposurePerLineIsSharedByItsPictures) {
  Eigen::VectorXd truth(kPictures);
  truth << Eigen::VectorXd::Constant(kOnLine, 0.01), Eigen::VectorXd::Constant(kOnLine, -0.01);
  const auto decision = decide_exposures(measured(truth, 1), two_lines());
  EXPECT_EQ(decision.model, ExposureModel::kLines);
  for (int i = 0; i < kPictures; ++i) {
    EXPECT_NEAR(decision.correction[i], decision.correction[i / kOnLine * kOnLine], 1e-12);
    EXPECT_NEAR(decision.correction[i], truth[i], 0.0015);
  }
}

TEST(ExposureDecisionTest, SteadyDriftIsFoundWithFewerErrorsThanSinglePictures) {
  Eigen::VectorXd truth(kPictures);
  for (int i = 0; i < kPictures; ++i) truth[i] = 0.004 * (i % kOnLine - 4);
  const auto decision = decide_exposures(measured(truth, 2), two_lines());
  EXPECT_EQ(decision.model, ExposureModel::kDrift);
  EXPECT_LT((decision.fitted - truth).cwiseAbs().maxCoeff(), 0.0015);
  EXPECT_LT(decision.error.maxCoeff(), 0.0008);
}

TEST(ExposureDecisionTest, OneDifferentPictureIsCorrectedAndTheOthersAreNot) {
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(kPictures);
  truth[5] = 0.03;
  int others = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto decision = decide_exposures(measured(truth, seed), two_lines());
    EXPECT_EQ(decision.model, ExposureModel::kStations);
    EXPECT_NEAR(decision.correction[5], 0.03, 0.005);
    others += static_cast<int>((decision.correction.array() != 0.0).count()) - 1;
  }
  EXPECT_LE(others, 0.03 * 50 * kPictures);
}

// A ramp that parts of the scene disagree about: its error is common to all pictures.
TEST(ExposureDecisionTest, RampWithinItsCommonErrorIsNotCorrected) {
  UncertainLight light = measured(Eigen::VectorXd::Zero(kPictures), 3);
  Eigen::VectorXd ramp(kPictures);
  for (int i = 0; i < kPictures; ++i) ramp[i] = 0.01 * (i % kOnLine - 4);
  light.value += ramp;
  EXPECT_EQ(decide_exposures(light, two_lines()).model, ExposureModel::kDrift);
  light.errors.conservativeResize(kPictures + 1, kPictures);
  light.errors.row(kPictures) = 0.5 * ramp.transpose();
  const auto decision = decide_exposures(light, two_lines());
  EXPECT_EQ(decision.model, ExposureModel::kEqual);
  EXPECT_TRUE(decision.correction.isZero(0.0));
}

TEST(ExposureDecisionTest, NothingIsDecidedWithoutDegreesOfFreedom) {
  UncertainLight light = measured(Eigen::VectorXd::Constant(kPictures, 1.0), 4);
  light.freedom = 0;
  EXPECT_TRUE(decide_exposures(light, two_lines()).correction.isZero(0.0));
  EXPECT_TRUE(decide_exposures(light, {}).tests.empty());
}

// From tables of the distribution.
TEST(StudentTTest, QuantilesAreThoseOfTables) {
  EXPECT_NEAR(two_sided_quantile(0.05, 1), 12.7062, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.01, 2), 9.9248, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.01, 10), 3.1693, 1e-4);
  EXPECT_NEAR(two_sided_quantile(0.001, 23), 3.7676, 1e-3);
  EXPECT_NEAR(two_sided_quantile(0.05, 1000), 1.9623, 1e-3);
}

TEST(StudentTTest, ProbabilityAndQuantileAreInverse) {
  for (const int freedom : {1, 2, 7, 23}) {
    EXPECT_NEAR(two_sided_probability(0.0, freedom), 1.0, 1e-12);
    for (const double probability : {0.5, 0.01, 1e-5}) {
      const double size = two_sided_quantile(probability, freedom);
      EXPECT_NEAR(two_sided_probability(size, freedom) / probability, 1.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace raywalk::calibrate
