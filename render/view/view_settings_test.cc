#include "render/view/view_settings.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <set>

#include "core/base/error.h"
#include "core/files/test_support.h"
#include "core/files/test_yaml_keys.h"
#include "core/room/requirements.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"
#include "render/view/measured_choice.h"
#include "render/view/presets.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

std::string message_of(const ViewFlags& flags) {
  return error_of([&] { view_settings(flags); });
}

class ViewSettingsTest : public ::testing::Test {
 protected:
  ViewFlags file_flags(const std::string& yaml) const {
    std::ofstream(directory_ / "view.yaml") << yaml;
    return {.settings = directory_ / "view.yaml"};
  }

  TestDirectory directory_;
};

TEST_F(ViewSettingsTest, TheShippedFileHoldsTheDefaultOfEveryParameter) {
  EXPECT_TRUE(view_settings({.settings = RAYWALK_CONFIGS "/view.yaml"}) == ViewSettings());
  std::set<std::string> keys{"preset", "connection"};
  for (const ViewParameter& parameter : kViewParameters) keys.insert(parameter.key);
  EXPECT_EQ(keys_of_yaml(RAYWALK_CONFIGS "/view.yaml"), keys);
}

// A value of a parameter that is not its default.
double other_value(const ViewParameter& parameter) {
  if (parameter.value.kind == ParameterKind::kChoice)
    return default_of(parameter) == 0.0 ? 1.0 : 0.0;
  return default_of(parameter) == parameter.least ? parameter.most : parameter.least;
}

TEST_F(ViewSettingsTest, EveryParameterCanBeSetInTheFileAndByFlag) {
  for (const ViewParameter& parameter : kViewParameters) {
    const std::string text = text_of(parameter, other_value(parameter));
    ViewSettings expected;
    parameter.value.set(&expected.options, other_value(parameter));
    ASSERT_FALSE(expected == ViewSettings()) << parameter.key;
    EXPECT_TRUE(view_settings(file_flags(parameter.key + (": " + text))) == expected)
        << parameter.key;
    EXPECT_TRUE(view_settings({.parameters = {{parameter.key, text}}}) == expected)
        << parameter.key;
    // And it reaches the renderer.
    EXPECT_EQ(parameter.value.get(view_mode(expected).options), other_value(parameter))
        << parameter.key;
  }
}

TEST_F(ViewSettingsTest, ParametersOutOfRangeAreRejected) {
  for (const char* line :
       {"stations_mixed: 17", "stations_mixed: 1.5", "distance_maps: 9", "distance_maps: '2'",
        "overlap_deg: 45.1", "overlap_deg: .nan", "width_px: 30", "k_deg: 0", "interpolation: best",
        "second_side: always", "preset: quick"}) {
    EXPECT_THAT(message_of(file_flags(std::string("k_deg: 80\n") + line)), HasSubstr("view.yaml:2"))
        << line;
  }
}

TEST_F(ViewSettingsTest, AConnectionOnTheCommandLineDoesNotInheritTheFilesK) {
  ViewFlags flags = file_flags("connection: hybrid\nk_deg: 70\n");
  flags.connection = "lfu";
  EXPECT_EQ(view_settings(flags).options.k_deg, 90.0);
}

TEST_F(ViewSettingsTest, MistakesInTheFileNameTheFile) {
  for (const auto& [yaml, message] : {std::pair("overlap_dge: 5\n", "did you mean 'overlap_deg'"),
                                      {"method: perfect\n", ":1"},
                                      {"k_deg: 30\n", "45..90"},
                                      {"connection: lfu\nk_deg: 60\n", "k = 45"}}) {
    EXPECT_THAT(message_of(file_flags(yaml)), AllOf(HasSubstr("view.yaml"), HasSubstr(message)));
  }
}

TEST_F(ViewSettingsTest, RejectsAKThatContradictsTheConnection) {
  const struct {
    std::string connection, k_deg, message;
  } cases[] = {{"lfu", "76", "k = 45"},      {"rayspace360", "45", "k = 90"},
               {"lfu", "45", "no error"},    {"rayspace360", "90.0", "no error"},
               {"hybrid", "44.9", "45..90"}, {"hybrid", "nan", "45..90"},
               {"hybrid", "80x", "45..90"}};
  for (const auto& [connection, k_deg, message] : cases) {
    EXPECT_THAT(message_of({.connection = connection, .parameters = {{"k_deg", k_deg}}}),
                HasSubstr(message));
  }
}

TEST(ViewModeTest, TheThreeConnectionsAreOneRuleWithTheirOwnK) {
  EXPECT_EQ(view_mode({.connection = "lfu"}).options.k_deg, 45.0);
  EXPECT_EQ(view_mode({.connection = "rayspace360"}).options.k_deg, 90.0);
  EXPECT_EQ(view_mode(view_settings({.parameters = {{"k_deg", "76"}}})).options.k_deg, 76.0);
  EXPECT_EQ(view_mode({}).options.k_deg, 90.0);
}

TEST(ViewModeTest, AllMethodsThatTheRoomSupports) {
  const auto methods = [](const std::vector<std::string>& names, const TestRoom& room) {
    std::vector<ViewMethod> found;
    for (const ViewMode& mode : view_modes({}, names, room.room())) {
      found.push_back(mode.options.method);
    }
    return found;
  };
  const TestRoom bare({.width = 32, .distances = false}), full({.width = 32});
  EXPECT_THAT(methods({}, bare), ElementsAre(ViewMethod::kInitial));
  EXPECT_THAT(methods({}, full), ElementsAreArray(kViewMethods));
  EXPECT_THAT(methods({"two-sided"}, full), ElementsAre(ViewMethod::kTwoSided));
  EXPECT_THROW(methods({"initial", "initial"}, full), UsageError);
}

constexpr const char* kNames[] = {"fast", "balanced", "accurate"};

// A cell of 1 m, surfaces from 0.5 m on.
SceneNumbers some_scene() {
  return {.has_distances = true, .inverse_max = 2.0, .reach_m = 0.5, .width_px = 1024};
}

TEST(PresetsTest, RulesDoNotDependOnTheUnitOfLength) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> exponent(-4.0, 4.0);
  const auto any = [&] { return std::pow(10.0, exponent(random)); };
  for (int i = 0; i < 1000; ++i) {
    SceneNumbers scene{
        .has_distances = true, .inverse_max = any(), .reach_m = any(), .width_px = 4 << (i % 13)};
    SceneNumbers larger = scene;
    constexpr double kScale = 1024.0;  // exact
    larger.inverse_max /= kScale;
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
  scene.inverse_max = 1.0 / 100.0;  // 0.5 m / 100 m * 1024 / 2 pi = 0.8 px
  EXPECT_EQ(preset_of("fast", scene).settings.options.method, ViewMethod::kInitial);
  scene.inverse_max = 1.0 / 80.0;  // 1.02 px
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
  EXPECT_GT(numbers.inverse_max, 1.0 / farthest_m);
  EXPECT_TRUE(std::isfinite(numbers.inverse_max));
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

MeasuredSettings some_trade() {
  const auto choice = [](const char* name, double ratio, double psnr_db) {
    MeasuredChoice made{.name = name, .ratio = ratio, .psnr_db = psnr_db};
    made.options.method = method_from_name(name);
    return made;
  };
  return {"",
          512,
          {choice("two-sided", 4.0, 37.0), choice("initial", 0.5, 17.0),
           choice("hlf-vd", 2.0, 36.0), choice("hlf-vd", 5.0, 35.0)}};
}

TEST(MeasuredChoiceTest, ChoosesTheBestWithinTheBudgetOfThisMachine) {
  const auto method_at = [](double budget_ms, double remap_ms) {
    const Preset chosen = choose_setting(some_trade(), {.budget_ms = budget_ms}, remap_ms);
    return chosen.settings.options.method;
  };
  EXPECT_EQ(method_at(25.0, 10.0), ViewMethod::kHlfVd);
  EXPECT_EQ(method_at(1e6, 10.0), ViewMethod::kTwoSided);
  EXPECT_EQ(method_at(25.0, 5.0), ViewMethod::kTwoSided);
  EXPECT_EQ(method_at(25.0, 40.0), ViewMethod::kInitial);
}

TEST(MeasuredChoiceTest, SaysWhyASettingWasChosenAndNamesTheNextBetter) {
  EXPECT_THAT(choose_setting(some_trade(), {.budget_ms = 25.0}, 10.0).reason,
              AllOf(HasSubstr("36.00 dB at 20 ms"), HasSubstr("within 25 ms"),
                    HasSubstr("37.00 dB would take 40 ms (two-sided)")));
  EXPECT_THAT(choose_setting(some_trade(), {.min_psnr_db = 35.5}, 10.0).reason,
              HasSubstr("the fastest with at least 35.5 dB"));
}

TEST(MeasuredChoiceTest, UnmetDemandsNameTheNearestSetting) {
  EXPECT_THAT(error_of([] { choose_setting(some_trade(), {.budget_ms = 4.0}, 10.0); }),
              AllOf(HasSubstr("budget of 4 ms"), HasSubstr("5 ms (initial)")));
  EXPECT_THAT(error_of([] { choose_setting(some_trade(), {.min_psnr_db = 40.0}, 10.0); }),
              AllOf(HasSubstr("reaches 40 dB"), HasSubstr("37.00 dB at 40 ms")));
  EXPECT_THAT(error_of([] {
                choose_setting(some_trade(), {.budget_ms = 19.0, .min_psnr_db = 35.0}, 10.0);
              }),
              AllOf(HasSubstr("19 ms with 35 dB"), HasSubstr("20 ms (hlf-vd)")));
}

TEST(MeasuredChoiceTest, DemandsThatNobodyCanMeanAreRefused) {
  EXPECT_NO_THROW(require_demand({.budget_ms = 1e-3, .min_psnr_db = 100.0}));
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0, 1e300}) {
    EXPECT_THROW(require_demand({.budget_ms = value}), UsageError) << value;
    EXPECT_THROW(require_demand({.min_psnr_db = value}), UsageError) << value;
  }
  EXPECT_THROW(require_demand({.budget_ms = 0.0}), UsageError);
}

TEST(MeasuredChoiceTest, NoOtherSettingMeetsADemandBetter) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> log_ratio(-3.0, 3.0), psnr_db(10.0, 50.0);
  for (int trial = 0; trial < 500; ++trial) {
    MeasuredSettings trade;
    for (int i = 0; i < 1 + trial % 9; ++i) {
      MeasuredChoice choice{.name = std::to_string(i),
                            .ratio = std::exp(log_ratio(random)),
                            .psnr_db = psnr_db(random)};
      choice.options.stations_mixed = i + 1;
      trade.choices.push_back(choice);
    }
    Demand demand;
    if (trial % 3 != 1) demand.budget_ms = 10.0 * std::exp(log_ratio(random));
    if (trial % 3 != 0) demand.min_psnr_db = psnr_db(random);
    const auto meets = [&](const MeasuredChoice& choice) {
      return (!demand.budget_ms || 10.0 * choice.ratio <= *demand.budget_ms) &&
             (!demand.min_psnr_db || choice.psnr_db >= *demand.min_psnr_db);
    };
    if (std::ranges::none_of(trade.choices, meets)) {
      EXPECT_THROW(choose_setting(trade, demand, 10.0), Error);
      continue;
    }
    const int number = choose_setting(trade, demand, 10.0).settings.options.stations_mixed;
    ASSERT_GE(number, 1);
    const MeasuredChoice* chosen = &trade.choices.at(static_cast<std::size_t>(number) - 1);
    EXPECT_TRUE(meets(*chosen));
    for (const MeasuredChoice& other : trade.choices) {
      if (!meets(other)) continue;
      if (demand.min_psnr_db) {
        EXPECT_GE(other.ratio, chosen->ratio);
      } else {
        EXPECT_LE(other.psnr_db, chosen->psnr_db);
      }
    }
  }
}

// What was measured on a room: one setting.
MeasuredSettings one_setting(const std::string& distances) {
  const MeasuredChoice quick{.name = "quick",
                             .options = {.k_deg = 76.5,
                                         .width = 32,
                                         .interpolation = Interpolation::kCubic,
                                         .stations_mixed = 2,
                                         .distance_maps = 3},
                             .ratio = 1.5,
                             .psnr_db = 30.0};
  return {.distances_sha256 = distances, .width_px = 32, .choices = {quick}};
}

class DemandedSettingsTest : public ::testing::Test {
 protected:
  std::string message(const Demand& demand) {
    return error_of([&] { demanded_settings({}, demand, room_); });
  }
  // As if trade had measured one setting on these distances.
  void measure_on(const std::string& distances) const {
    write_measured_settings(room_.directory(), one_setting(distances));
  }
  TestRoom made_{{.width = 32}};
  const Room& room_ = made_.room();
};

TEST_F(DemandedSettingsTest, ComeFromTheRoomsTradeWithFlagsOnTop) {
  measure_on(distances_sha256(room_));
  ViewFlags flags;
  flags.parameters["distance_maps"] = "1";
  const Preset chosen = demanded_settings(flags, {.min_psnr_db = 25.0}, room_);
  ViewSettings expected{.options = one_setting("").choices[0].options};
  expected.options.distance_maps = 1;
  EXPECT_TRUE(chosen.settings == expected);
  EXPECT_EQ(chosen.k_source, "of the setting that trade measured");
  EXPECT_THAT(chosen.reason, HasSubstr("quick: 30.00 dB"));
}

TEST_F(DemandedSettingsTest, AKThatIsAskedForIsNotTheTrades) {
  measure_on(distances_sha256(room_));
  for (const ViewFlags& flags :
       {ViewFlags{.parameters = {{"k_deg", "76.5"}}}, ViewFlags{.parameters = {{"k_deg", "80"}}},
        ViewFlags{.connection = "lfu"}}) {
    EXPECT_EQ(demanded_settings(flags, {.min_psnr_db = 25.0}, room_).k_source, "");
  }
}

// Without work, the remap takes as long as the clock says: a hiccup and the warm-up do not count.
TEST_F(DemandedSettingsTest, TheRemapIsTimedOnThisMachine) {
  measure_on(distances_sha256(room_));
  int runs = 0;
  const TimeSource source = [&](const std::function<void()>&) {
    ++runs;
    return runs == 1 || runs == 3 ? 1.0 : 0.01;
  };
  const Preset chosen = demanded_settings({}, {.budget_ms = 20.0}, room_, source);
  EXPECT_EQ(runs, 6);
  EXPECT_THAT(chosen.reason, HasSubstr("30.00 dB at 15 ms"));
}

TEST_F(DemandedSettingsTest, NeedATradeOfTheCurrentDistances) {
  EXPECT_THAT(message({.budget_ms = 1e6}), HasSubstr("run raywalk-render trade on it first"));
  measure_on("other");
  EXPECT_THAT(message({.budget_ms = 1e6}),
              AllOf(HasSubstr("measured.json: "), HasSubstr("other distances")));
}

}  // namespace
}  // namespace raywalk::render
