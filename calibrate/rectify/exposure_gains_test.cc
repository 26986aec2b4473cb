#include "calibrate/rectify/exposure_gains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

constexpr int kPerLine = 9;
constexpr int kFrames = 2 * kPerLine;

// Two parallel lines of nine frames that see the same 200 surfaces around them; the lines are
// joined by links across.
struct Scene {
  std::vector<Eigen::Vector3d> surfaces{};
  std::vector<FrameLink> links{};
  std::vector<PictureLine> lines = std::vector<PictureLine>(2);

  Scene() {
    constexpr int kSurfaces = 200;
    constexpr double kGoldenAngle = 2.39996;
    for (int i = 0; i < kSurfaces; ++i) {
      const double y = 1.0 - 2.0 * (i + 0.5) / kSurfaces;
      const double breadth = std::sqrt(1.0 - y * y);
      surfaces.emplace_back(breadth * std::cos(kGoldenAngle * i), y,
                            breadth * std::sin(kGoldenAngle * i));
    }
    for (int i = 0; i < kFrames; ++i) {
      const int line = i / kPerLine;
      lines[static_cast<std::size_t>(line)].pictures.push_back(i);
      lines[static_cast<std::size_t>(line)].along_m.push_back(0.1 * (i % kPerLine));
      for (const int to : {i + 1, i + 2}) {
        if (to < kFrames && to / kPerLine == line) links.push_back({i, to});
      }
      if (line == 0 && i % 4 == 0) links.push_back({i, i + kPerLine});
    }
  }
};

// What makes the measurements of a surface wrong, beside noise that is different for every link.
struct Errors {
  double noise = 0.01;
  double ramp_by_surface = 0.0;      // every surface has its own apparent drift along the lines
  double ramp_of_bad_matches = 0.0;  // the same for all surfaces that match badly
  double vignetting = 0.0;
};

using Light = std::vector<Eigen::Array3d>;  // logarithms, by frame

ExposureResult measure(const Light& light, const Errors& errors, unsigned seed) {
  const Scene scene;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> ramps;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    ramps.push_back(errors.ramp_by_surface * normal(random));
  }
  std::vector<LinkPatches> links;
  for (const FrameLink link : scene.links) {
    LinkPatches compared{.link = link};
    const double moved = link.to % kPerLine - link.from % kPerLine;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
      const bool bad = i % 4 == 1;
      const Eigen::Vector3d& seen = scene.surfaces[i];
      // Moving along x shifts the surface towards -x in the picture.
      const Eigen::Vector3d seen_to = (seen - 0.05 * moved * Eigen::Vector3d::UnitX()).normalized();
      const auto dark = [&](const Eigen::Vector3d& at) {
        return -errors.vignetting * (1.0 - at.z() * at.z());
      };
      const double wrong = errors.noise * normal(random) + moved * ramps[i] +
                           (bad ? moved * errors.ramp_of_bad_matches : 0.0) + dark(seen_to) -
                           dark(seen);
      compared.patches.push_back({.point_m = 2.0 * seen,
                                  .log_ratio = light[static_cast<std::size_t>(link.to)] -
                                               light[static_cast<std::size_t>(link.from)] + wrong,
                                  // Half of the matches are no good and not used.
                                  .error = i % 2 == 0 ? 1.0 : (bad ? 0.02 : 0.01),
                                  .parallax = 0.05 + 1e-4 * static_cast<double>((7 * i) % 50),
                                  .ahead = std::abs(seen.x()),
                                  .seen_from = seen,
                                  .seen_to = seen_to});
    }
    links.push_back(std::move(compared));
  }
  return measure_exposures(links, kFrames, scene.lines, Eigen::Vector3d::Zero());
}

Light equal_light() { return Light(kFrames, Eigen::Array3d::Zero()); }

Light spread_light(double spread, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, spread);
  Light light = equal_light();
  for (Eigen::Array3d& rgb : light) rgb = normal(random);
  Eigen::Array3d mean = Eigen::Array3d::Zero();
  for (const Eigen::Array3d& rgb : light) mean += rgb / kFrames;
  for (Eigen::Array3d& rgb : light) rgb -= mean;
  return light;
}

bool untouched(const ExposureResult& result) {
  return std::all_of(result.gains.begin(), result.gains.end(), [](const LightGain& gain) {
    return gain == LightGain{1.0, 1.0, 1.0};
  });
}

TEST(ExposureGainsTest, EqualExposuresHaveGainsOfExactlyOne) {
  int touched = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    touched += untouched(measure(equal_light(), {}, seed)) ? 0 : 1;
  }
  // Three kinds of light at 1 % each.
  EXPECT_LE(touched, 3);
}

// Surfaces whose light seems to change along the line, each in its own way, are no exposure.
TEST(ExposureGainsTest, RampsThatSurfacesDisagreeAboutAreNotCorrected) {
  int touched = 0;
  double largest = 0.0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const auto result = measure(equal_light(), {.ramp_by_surface = 0.01}, seed);
    touched += untouched(result) ? 0 : 1;
    largest = std::max(largest, result.light[0].spread);
  }
  EXPECT_LE(touched, 3);
  EXPECT_GT(largest, 0.003);  // there is something to be mistaken
}

// All parts of the scene agree on a ramp, but good and bad matches do not.
TEST(ExposureGainsTest, HalvesThatDisagreeRevealACommonError) {
  const auto result = measure(equal_light(), {.ramp_of_bad_matches = 0.01}, 1);
  EXPECT_TRUE(untouched(result));
  const HalvesComparison& quality = result.light[0].halves[0];
  EXPECT_EQ(quality.split, "match quality");
  EXPECT_GT(quality.difference, 3.0 * quality.by_chance);
  const auto clean = measure(equal_light(), {}, 1);
  EXPECT_LT(clean.light[0].halves[0].difference, 2.0 * clean.light[0].halves[0].by_chance);
}

TEST(ExposureGainsTest, VignettingIsNotExposure) {
  const auto result = measure(equal_light(), {.vignetting = 0.3}, 1);
  EXPECT_TRUE(untouched(result));
  EXPECT_LT(result.light[0].spread, 0.003);
}

// The errors are as large as stated: 95 % within two standard errors.
TEST(ExposureGainsTest, ExposuresAreFoundWithinTheirStatedErrors) {
  int within = 0, count = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Light light = spread_light(0.05, seed);
    const auto result = measure(light, {.ramp_by_surface = 0.002}, seed + 100);
    const ExposureDecision& decision = result.light[0].decision;
    EXPECT_EQ(decision.model, ExposureModel::kStations);
    EXPECT_EQ(result.light[1].decision.model, ExposureModel::kEqual);
    for (int i = 0; i < kFrames; ++i) {
      const double wrong = decision.measured[i] - light[static_cast<std::size_t>(i)].mean();
      EXPECT_LT(std::abs(wrong), 0.01);
      within += std::abs(wrong) < 2.07 * decision.error[i] ? 1 : 0;
      ++count;
    }
  }
  EXPECT_GT(within, 0.88 * count);
}

TEST(ExposureGainsTest, GainsUndoExposuresAndColours) {
  Light light = spread_light(0.05, 3);
  light[4] += Eigen::Array3d(0.04, 0.0, -0.04);
  const auto result = measure(light, {}, 3);
  double common = 0.0;
  for (std::size_t i = 0; i < kFrames; ++i) {
    common += (std::log(result.gains[i][1]) + light[i][1]) / kFrames;
  }
  for (std::size_t i = 0; i < kFrames; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto channel = static_cast<Eigen::Index>(c);
      EXPECT_NEAR(std::log(result.gains[i][c]) + light[i][channel], common, 0.012) << i;
    }
  }
  EXPECT_NE(result.gains[4][0], result.gains[4][2]);
}

TEST(ExposureGainsTest, UnlinkedFramesAreLeftAlone) {
  const std::vector<PictureLine> lines{{.pictures = {0, 1}, .along_m = {0.0, 0.1}}};
  for (const auto& links : {std::vector<LinkPatches>{}, std::vector<LinkPatches>{{{0, 1}, {}}}}) {
    const ExposureResult result = measure_exposures(links, 2, lines, Eigen::Vector3d::Zero());
    EXPECT_TRUE(untouched(result));
    EXPECT_EQ(result.links, 0);
    EXPECT_FALSE(result.measured[0]);
  }
}

TEST(LevelsUnderGainTest, LightIsMultiplied) {
  const LevelsUnderGain levels(LightGain{1.7, 1.0, 0.5});
  for (float level = 0.0f; level <= 255.0f; level += 0.37f) {
    const cv::Vec3f changed = levels({level, level, level});
    EXPECT_NEAR(changed[0], srgb_level_from_linear(0.5 * linear_from_srgb_level(level)), 0.01);
    EXPECT_NEAR(changed[1], level, 0.001);
    EXPECT_NEAR(changed[2], srgb_level_from_linear(1.7 * linear_from_srgb_level(level)), 0.01);
  }
}

TEST(LevelsUnderGainTest, OvershootOfCubicsIsClamped) {
  const LevelsUnderGain levels(LightGain{1.0, 1.0, 1.0});
  const cv::Vec3f changed = levels({-20.0f, 300.0f, 255.0f});
  EXPECT_NEAR(changed[0], 0.0, 0.001);
  EXPECT_NEAR(changed[1], 255.0, 0.001);
  EXPECT_NEAR(changed[2], 255.0, 0.001);
}

}  // namespace
}  // namespace raywalk::calibrate
