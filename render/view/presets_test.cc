#include "render/view/presets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "core/base/error.h"
#include "core/base/test_log.h"
#include "core/files/test_directory.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;

constexpr const char* kNames[] = {"fast", "balanced", "accurate"};

// A cell of 1 m, surfaces from 0.5 m on.
SceneNumbers some_scene() {
  return {.has_distances = true, .omega_max = 2.0, .reach_m = 0.5, .width_px = 1024};
}

TEST(PresetsTest, RulesDoNotDependOnTheUnitOfLength) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> exponent(-4.0, 4.0);
  const auto any = [&] { return std::pow(10.0, exponent(random)); };
  for (int i = 0; i < 1000; ++i) {
    SceneNumbers scene{
        .has_distances = true, .omega_max = any(), .reach_m = any(), .width_px = 4 << (i % 13)};
    SceneNumbers larger = scene;
    constexpr double kScale = 1024.0;  // exact
    larger.omega_max /= kScale;
    larger.reach_m *= kScale;
    for (const char* name : kNames) {
      EXPECT_TRUE(preset_of(name, scene).settings == preset_of(name, larger).settings) << name;
      EXPECT_EQ(preset_of(name, scene).reason.find("nan"), std::string::npos);
    }
  }
}

TEST(PresetsTest, FarScenesNeedNoCorrectionAndNearOnesDo) {
  SceneNumbers scene = some_scene();
  EXPECT_EQ(preset_of("fast", scene).settings.options.method, ViewMethod::kHlfVd);
  scene.omega_max = 1.0 / 100.0;  // 0.5 m / 100 m * 1024 / 2 pi = 0.8 px
  EXPECT_EQ(preset_of("fast", scene).settings.options.method, ViewMethod::kInitial);
  scene.omega_max = 1.0 / 80.0;  // 1.02 px
  EXPECT_EQ(preset_of("fast", scene).settings.options.method, ViewMethod::kHlfVd);
}

TEST(PresetsTest, WithoutDistancesViewsAreInitial) {
  for (const char* name : kNames) {
    const Preset preset = preset_of(name, {.reach_m = 0.5, .width_px = 1024});
    EXPECT_EQ(preset.settings.options.method, ViewMethod::kInitial);
    EXPECT_THAT(preset.reason, HasSubstr("no distances"));
  }
  EXPECT_THROW(preset_of("best", some_scene()), UsageError);
}

class PresetSettingsTest : public ::testing::Test {
 protected:
  TestDirectory directory_;
  TestRoom made_{{.width = 64}};
  const Room& room_ = made_.room();
};

TEST_F(PresetSettingsTest, NumbersAreThoseOfTheRoom) {
  const SceneNumbers numbers = scene_numbers(room_);
  EXPECT_TRUE(numbers.has_distances);
  EXPECT_NEAR(numbers.reach_m, 0.5, 1e-9);
  EXPECT_EQ(numbers.width_px, 64);
  const SceneBox walls = SyntheticRoomSpec().scene.walls;
  const double farthest_m = (walls.max_m - walls.min_m).norm();
  EXPECT_GT(numbers.omega_max, 1.0 / farthest_m);
  EXPECT_TRUE(std::isfinite(numbers.omega_max));
}

TEST_F(PresetSettingsTest, FlagsAndFileOverrideThePreset) {
  const Preset plain = preset_settings({.preset = "accurate"}, room_);
  EXPECT_EQ(plain.settings.options.interpolation, Interpolation::kCubic);
  EXPECT_EQ(plain.settings.options.method, ViewMethod::kTwoSided);
  EXPECT_THAT(plain.reason, HasSubstr("preset accurate: "));
  std::ofstream(directory_ / "view.yaml") << "preset: accurate\nmethod: hlf-vd\ndistance_maps: 3\n";
  ViewFlags flags{.settings = directory_ / "view.yaml"};
  flags.parameters["distance_maps"] = "2";
  const Preset mixed = preset_settings(flags, room_);
  EXPECT_EQ(mixed.settings.options.interpolation, Interpolation::kCubic);
  EXPECT_EQ(mixed.settings.options.method, ViewMethod::kHlfVd);
  EXPECT_EQ(mixed.settings.options.distance_maps, 2);
  EXPECT_TRUE(preset_settings({}, room_).settings == ViewSettings());
  EXPECT_TRUE(preset_settings({}, room_).reason.empty());
}

TEST_F(PresetSettingsTest, ARoomWithoutDistancesIsWarnedOf) {
  const auto warning = [](const ViewFlags& flags, const Room& room) {
    const CapturedLog log;
    preset_settings(flags, room);
    return log.text();
  };
  const TestRoom bare({.width = 64, .distances = false});
  EXPECT_THAT(warning({.preset = "accurate"}, bare.room()),
              HasSubstr("run raywalk-build-lf depth"));
  EXPECT_EQ(warning({}, bare.room()), "");
  EXPECT_EQ(warning({.preset = "accurate"}, room_), "");
}

TEST_F(PresetSettingsTest, EveryPresetRenders) {
  for (const char* name : kNames) {
    const Preset preset = preset_settings({.preset = name}, room_);
    Renderer renderer(room_, view_mode(preset.settings).options);
    EXPECT_EQ(renderer.render({0.1, 0.2}).image.cols, 64) << name;
  }
}

}  // namespace
}  // namespace raywalk::render
