#include "build_lf/require/scene_facts.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "build_lf/require/held_out.h"
#include "build_lf/require/test_distances.h"
#include "core/files/test_support.h"
#include "core/geometry/error_model.h"
#include "core/geometry/spacing.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;

class SceneFactsTest : public RequireTest {};

TEST_F(SceneFactsTest, RangesAreThoseOfTheRoom) {
  SyntheticRoomSpec spec{.side_m = 0.2, .spacing_m = 0.1, .width = 128};
  spec.scene.walls = {{-4.0, -1.0, -2.0}, {3.0, 1.5, 5.0}};
  const DistanceFacts facts = distance_facts(room_of(spec));
  // The floor is nearest, 1 m below; the farthest edge lies beyond the wall 5 m ahead.
  EXPECT_NEAR(facts.near_m, 1.0, 0.03);
  EXPECT_GT(facts.far_m, 5.0);
  EXPECT_LT(facts.near_m, facts.median_m);
  EXPECT_EQ(facts.sky_share, 0.0);
  EXPECT_NEAR(facts.known_share, 1.0, 1e-6);
}

TEST_F(SceneFactsTest, SkyIsInfinitelyFar) {
  SyntheticRoomSpec spec{.width = 64};
  spec.scene.infinitely_far = true;
  const DistanceFacts facts = distance_facts(room_of(spec));
  EXPECT_TRUE(std::isinf(facts.near_m));
  EXPECT_EQ(facts.sky_share, 1.0);
  const LayerFacts layers = layer_facts(facts, 0.5, 1e-3);
  EXPECT_EQ(layers.inverse_max_per_m, 0.0);
  for (const LayersAtDistance& each : layers.by_d_p) EXPECT_EQ(each.layers, 1);
}

TEST_F(SceneFactsTest, PixelsAreWeightedByConfidence) {
  room_of({.width = 64});
  replace_distances([](float metres) { return metres; }, 51);
  EXPECT_NEAR(distance_facts(Room::open(path_)).known_share, 0.2, 1e-3);
}

TEST_F(SceneFactsTest, RoomWithoutKnownDistancesIsAnError) {
  const auto message_of = [](const Room& room) { return error_of([&] { distance_facts(room); }); };
  const auto names_both = ::testing::AllOf(
      HasSubstr(path_.string()), HasSubstr("raywalk-build-lf depth"),
      HasSubstr("raywalk-build-lf pack --distance"), ::testing::Not(HasSubstr("\n")));
  EXPECT_THAT(message_of(room_of({.width = 32, .distances = false})), names_both);
  room_of({.width = 32});
  replace_distances([](float metres) { return metres; }, 0);
  EXPECT_THAT(message_of(Room::open(path_)), names_both) << "maps of confidence 0 know nothing";
}

TEST(LayerFactsTest, AreCountedForTheRangeAndEachDistance) {
  const LayerFacts facts = layer_facts({.near_m = 0.5, .far_m = INFINITY}, 0.5, 1e-3);
  EXPECT_EQ(facts.inverse_min_per_m, 0.0);
  EXPECT_EQ(facts.inverse_max_per_m, 2.0);
  int last = 0;
  for (const LayersAtDistance& each : facts.by_d_p) {
    EXPECT_EQ(each.layers, layers_for_tolerance({0.0, 2.0}, each.d_p_m, 1e-3));
    EXPECT_GT(each.layers, last);
    last = each.layers;
  }
}

TEST(TypicalReach, IsHalfTheSmallestCell) {
  EXPECT_DOUBLE_EQ(typical_reach_m(synthetic_grid({.cells_x = 2, .cells_z = 3, .side_m = 0.8})),
                   0.4);
  EXPECT_DOUBLE_EQ(typical_reach_m(synthetic_grid({.cells_z = 0, .side_m = 3.0})), 1.5);
}

TEST_F(SceneFactsTest, ExactMapsHaveNearlyNoError) {
  const auto error = inverse_error(room_of({.width = 256}));
  ASSERT_TRUE(error);
  EXPECT_LT(*error, 2e-3);
}

TEST_F(SceneFactsTest, NoiseIsMeasured) {
  room_of({.width = 256});
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.005);  // 1/m; 95 % are within 1.96 of it
  replace_distances(
      [&](float metres) { return static_cast<float>(1.0 / (1.0 / metres + noise(random))); });
  const auto error = inverse_error(Room::open(path_));
  ASSERT_TRUE(error);
  // Interpolation reduces the noise of one of the two maps.
  EXPECT_NEAR(*error, 1.96 * 0.005, 0.35 * 1.96 * 0.005);
}

TEST_F(SceneFactsTest, OneMapHasNothingToCompareWith) {
  EXPECT_FALSE(inverse_error(room_of({.cells_z = 0, .width = 64, .distance_every = 1000})));
  EXPECT_FALSE(inverse_error(room_of({.width = 64, .distances = false})));
}

TEST_F(SceneFactsTest, DistancesThatViewsIgnoreDoNotCount) {
  room_of({.width = 64});
  replace_distances([](float metres) { return metres; }, kMinConfidence);
  EXPECT_TRUE(inverse_error(Room::open(path_)));
  replace_distances([](float metres) { return metres; }, kMinConfidence - 1);
  EXPECT_FALSE(inverse_error(Room::open(path_)));
}

TEST_F(SceneFactsTest, SkyIsAgreement) {
  SyntheticRoomSpec spec{.width = 64};
  spec.scene.infinitely_far = true;
  // Sky is stored as infinity.
  EXPECT_EQ(inverse_error(room_of(spec)), 0.0);
}

TEST(UsefulWidth, IsWhereResidualParallaxEqualsTheTolerance) {
  const StorageNeed need{
      .reach_m = 0.5, .spacing_m = 0.0, .tolerance_px = 0.5, .inverse_error = 0.01};
  const double width_px = useful_width(need);
  // Independent computation: the largest latitude error for a source at 4 m with a wrong distance.
  double worst_rad = 0.0;
  for (int degree = 0; degree <= 90; ++degree) {
    const double alpha_rad = radians_from_degrees(degree);
    const double wrong_m = 1.0 / (0.25 + 0.01);
    worst_rad = std::max(worst_rad, std::abs(latitude_shift(4.0, alpha_rad, 0.5) -
                                             latitude_shift(wrong_m, alpha_rad, 0.5)));
  }
  EXPECT_NEAR(worst_rad, angle_of_pixels(0.5, static_cast<int>(width_px)), 0.05 * worst_rad);
}

TEST(UsefulWidth, FallsWithErrorReachAndSpacing) {
  const StorageNeed need{
      .reach_m = 0.5, .spacing_m = 0.2, .tolerance_px = 0.5, .inverse_error = 0.01};
  const double width_px = useful_width(need);
  const auto with = [&](double StorageNeed::*member, double factor) {
    StorageNeed other = need;
    other.*member *= factor;
    return useful_width(other);
  };
  EXPECT_LT(with(&StorageNeed::reach_m, 2.0), 0.6 * width_px);
  EXPECT_LT(with(&StorageNeed::spacing_m, 10.0), 0.6 * width_px);
  EXPECT_DOUBLE_EQ(with(&StorageNeed::inverse_error, 2.0), 0.5 * width_px);
  EXPECT_TRUE(std::isinf(with(&StorageNeed::inverse_error, 0.0)));
}

TEST_F(SceneFactsTest, SmoothDistancesNeedCoarseMapsAndDetailedOnesFine) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.5, .width = 512};
  const StorageNeed need{.reach_m = 0.5, .tolerance_px = 0.5};
  const DistanceWidth smooth = distance_width_needed(room_of(spec), need);
  EXPECT_LE(smooth.width_px, 128);
  EXPECT_GE(smooth.share_within_tolerance, kKeptShare);
  // Stripes of 2 pixels alternate between two distances: half the width cannot hold them.
  replace_distances([pixel = 0](float metres) mutable {
    const int theta = pixel++ / 256;
    return theta / 2 % 2 == 0 ? metres : 0.6f * metres;
  });
  EXPECT_GT(distance_width_needed(Room::open(path_), need).width_px, 128);
  EXPECT_LT(smooth.width_px, distance_width_needed(Room::open(path_), need).width_px);
}

TEST_F(SceneFactsTest, TighterToleranceNeedsFinerMaps) {
  const Room room = room_of({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.5, .width = 512});
  const auto width_for = [&](double tolerance_px) {
    return distance_width_needed(room, {.reach_m = 0.5, .tolerance_px = tolerance_px}).width_px;
  };
  EXPECT_LT(width_for(1.0), width_for(0.02));
}

TEST_F(SceneFactsTest, BytesAreThoseOfTheFilesWithoutHeaders) {
  const Room room = room_of({.width = 64, .distance_every = 2, .distance_width = 32});
  // 9 stations and 5 maps on each of 4 lines.
  const StorageFacts facts = storage_facts(room,
                                           {.reach_m = 0.5,
                                            .spacing_m = 0.125,
                                            .tolerance_px = 0.5,
                                            .inverse_error = 0.01,
                                            .scene = {0.2, 1.0}},
                                           10);
  EXPECT_EQ(facts.ray_bytes, 36U * 64 * 32 * 3);
  EXPECT_EQ(facts.ray_bytes_thinned, 10U * 64 * 32 * 3);
  EXPECT_EQ(facts.ray_bytes_worth, facts.ray_bytes_thinned) << "a wider panorama would be of use";
  EXPECT_EQ(facts.distance_bytes, 20U * 32 * 16 * 5);
  EXPECT_EQ(facts.distance_width_px, 32);
  EXPECT_EQ(facts.inverse_steps, layers_for_tolerance({0.2, 1.0}, 0.5, angle_of_pixels(0.5, 64)));
  EXPECT_EQ(facts.inverse_bits, static_cast<int>(std::ceil(std::log2(facts.inverse_steps + 2))));
  EXPECT_LT(facts.distance_bytes_needed, facts.distance_bytes);
}

class HeldOutTest : public RequireTest {};

TEST_F(HeldOutTest, StridesGoUpToTheWholeLine) {
  const Room room = room_of({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 64});
  const std::vector<HeldOutFacts> strides = measure_strides(room, 0.125, 0.5);
  std::vector<int> found;
  for (const HeldOutFacts& each : strides) {
    found.push_back(each.stride);
    EXPECT_NEAR(each.step_m, 0.125 * each.stride, 1e-9);
    EXPECT_EQ(each.views, 8 / each.stride);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(2, 3, 4, 6, 8));
  EXPECT_GT(strides.front().psnr_without_depth_db, strides.back().psnr_without_depth_db + 6.0);
}

TEST_F(HeldOutTest, WrongDistancesLoseWithEveryStride) {
  const SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const std::vector<HeldOutFacts> right = measure_strides(room_of(spec), 0.125, 0.5);
  replace_distances([](float metres) { return 1.3f * metres; });
  const std::vector<HeldOutFacts> wrong = measure_strides(Room::open(path_), 0.125, 0.5);
  ASSERT_EQ(wrong.size(), right.size());
  for (size_t i = 0; i < right.size(); ++i) {
    EXPECT_LT(wrong[i].psnr_with_distances_db, right[i].psnr_with_distances_db - 1.0) << i;
    EXPECT_GT(wrong[i].psnr_with_distances_db, wrong[i].psnr_without_depth_db + 3.0)
        << "a quarter of the parallax is left";
    EXPECT_EQ(wrong[i].psnr_without_depth_db, right[i].psnr_without_depth_db);
    EXPECT_EQ(wrong[i].psnr_of_tolerance_db, right[i].psnr_of_tolerance_db);
  }
}

TEST_F(HeldOutTest, TheToleranceIsThatOfADisplacedPicture) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const Room room = room_of(spec);
  // Twice the displacement is four times the squared error where texture is coarse.
  EXPECT_NEAR(measure_strides(room, 0.125, 1.0).front().psnr_of_tolerance_db -
                  measure_strides(room, 0.125, 2.0).front().psnr_of_tolerance_db,
              6.0, 0.7);
  spec.scene.contrast = 0.0;
  EXPECT_EQ(measure_strides(room_of(spec), 0.125, 0.5).front().psnr_of_tolerance_db, 100.0)
      << "of a blank wall any displacement is right";
}

TEST_F(HeldOutTest, MaskedPixelsAreNotCompared) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const auto measured = [&] { return measure_strides(room_of(spec), 0.125, 0.5).front(); };
  const HeldOutFacts clean = measured();
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return direction.y() < -0.8;
      }};
  const HeldOutFacts masked = measured();
  EXPECT_NEAR(masked.psnr_with_distances_db, clean.psnr_with_distances_db, 1.0);
  EXPECT_NEAR(masked.psnr_without_depth_db, clean.psnr_without_depth_db, 2.0);
  spec.companion->masked = false;
  EXPECT_LT(measured().psnr_with_distances_db, masked.psnr_with_distances_db - 5.0);
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d&) { return true; }};
  EXPECT_EQ(measured().psnr_with_distances_db, 100.0) << "nothing is compared";
}

TEST_F(HeldOutTest, StationsOffTheirLineAreRenderedAtTheirOwnPlace) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 2.0, .spacing_m = 0.125, .width = 256};
  spec.off_line = [](const std::string&, int station) {
    return station % 2 == 1 ? OffLine{.across_m = 0.03, .up_m = -0.02} : OffLine{};
  };
  const HeldOutFacts facts = measure_strides(room_of(spec), 0.125, 0.5).front();
  EXPECT_GT(facts.psnr_with_distances_db, 38.0);
  EXPECT_GT(facts.psnr_with_distances_db, facts.psnr_without_depth_db + 10.0);
}

TEST(MeasuredUpTo, EndsBeforeTheFirstStepThatFails) {
  const auto step = [](double step_m, double psnr_db) {
    return HeldOutFacts{
        .step_m = step_m, .psnr_with_distances_db = psnr_db, .psnr_of_tolerance_db = 30.0};
  };
  EXPECT_EQ(
      measured_up_to_m(std::array{step(0.1, 40), step(0.2, 30), step(0.3, 29), step(0.4, 31)}),
      0.2);
  EXPECT_EQ(measured_up_to_m(std::array{step(0.1, 29), step(0.2, 31)}), 0.0);
  EXPECT_EQ(measured_up_to_m({}), 0.0);
}

// --- The spacing rule (core/geometry/spacing.h) on rendered pictures: stations are moved apart
// until the blended picture has the error of one displaced by the tolerance
// ----------------------------

constexpr int kWidth = 1024;
constexpr double kHalfPatchDeg = 3.0;

// A wall in front of a rail along x: the distance within the patch around theta = 0 is `distance_m`
// to 0.2 %.
SyntheticScene wall_at(double distance_m) {
  SyntheticScene scene;
  const double far_m = 20.0 * distance_m;
  scene.walls = {{-far_m, -far_m, -far_m}, {far_m, far_m, distance_m}};
  // About 12 pixels, so that a displacement of half a pixel is measurable.
  scene.texture_wavelength_m = distance_m * angle_of_pixels(12.0, kWidth);
  return scene;
}

// Mean squared difference, over the patch in front, between the view and the mean of two others,
// shifted by `shift_px` columns to either side.
double blend_error(const cv::Mat& view, const cv::Mat& left, const cv::Mat& right,
                   double shift_px) {
  const auto level = [](const cv::Mat& image, double u, int v, int channel) {
    const int whole = static_cast<int>(std::floor(u));
    const double part = u - whole;
    const auto at = [&](int column) {
      return static_cast<double>(image.at<cv::Vec3b>(v, column)[channel]);
    };
    // Catmull-Rom cubic: the blur of linear interpolation would exceed the effect of the
    // displacement.
    const double a = at(whole - 1), b = at(whole), c = at(whole + 1), d = at(whole + 2);
    return b +
           0.5 * part * (c - a + part * (2 * a - 5 * b + 4 * c - d + part * (3 * (b - c) + d - a)));
  };
  const int half = static_cast<int>(kHalfPatchDeg / 360.0 * kWidth);
  double sum = 0.0;
  int count = 0;
  for (int v = kWidth / 4 - half; v < kWidth / 4 + half; ++v) {
    for (int u = kWidth / 2 - half; u < kWidth / 2 + half; ++u) {
      for (int channel = 0; channel < 3; ++channel) {
        const double blend =
            0.5 * (level(left, u - shift_px, v, channel) + level(right, u + shift_px, v, channel));
        const double difference = blend - level(view, u, v, channel);
        sum += difference * difference;
        ++count;
      }
    }
  }
  return sum / count;
}

struct Case {
  double distance_m;
  double tolerance_px;
  double assumed_inverse;  // that the samples are moved by; 0: blended in place
};

class MeasuredSpacing : public testing::TestWithParam<Case> {};

TEST_P(MeasuredSpacing, ErrorReachesTheToleranceAtThePredictedSpacing) {
  const Case& c = GetParam();
  const SyntheticScene scene = wall_at(c.distance_m);
  const cv::Mat view = render_scene(scene, {0, 0, 0}, kWidth);
  const double of_tolerance = blend_error(view, view, view, 0.5 * c.tolerance_px);
  const double inverse = 1.0 / c.distance_m, nearer = std::min(inverse, c.assumed_inverse);
  const double rule_m = spacing_needed({nearer, nearer}, std::abs(inverse - c.assumed_inverse),
                                       angle_of_pixels(c.tolerance_px, kWidth));
  const auto error_at = [&](double step_m) {
    const double half_m = 0.5 * step_m;
    const cv::Mat left = render_scene(scene, {-half_m, 0, 0}, kWidth);
    const cv::Mat right = render_scene(scene, {half_m, 0, 0}, kWidth);
    // The left station sees the point straight ahead further to the right: + columns.
    const double moved_px = -std::atan(half_m * c.assumed_inverse) / angle_of_pixels(1.0, kWidth);
    return blend_error(view, left, right, moved_px);
  };
  // The error grows with the square of the gap: 10 % of the step changes it by 20 %.
  EXPECT_LT(error_at(0.9 * rule_m), of_tolerance);
  EXPECT_GT(error_at(1.1 * rule_m), of_tolerance);
}

INSTANTIATE_TEST_SUITE_P(Scenes, MeasuredSpacing,
                         testing::Values(Case{1.0, 2.0, 0.0}, Case{1.0, 4.0, 0.0},
                                         Case{25.0, 3.0, 0.0}, Case{0.2, 3.0, 0.0},
                                         // Chai's optimal depth for a scene from 1 m to the sky.
                                         Case{1.0, 3.0, 0.5},
                                         // Distances 10 % too large.
                                         Case{2.0, 2.0, 0.45}, Case{2.0, 3.0, 0.55}));

}  // namespace
}  // namespace raywalk::build_lf
