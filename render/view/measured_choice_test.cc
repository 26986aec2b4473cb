#include "render/view/measured_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/test_directory.h"
#include "core/room/requirements.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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

TEST(MeasuredChoiceTest, ChoosesTheBestWithinTheBudgetAndNamesTheNextBetter) {
  const Preset chosen = choose_setting(some_trade(), {.budget_ms = 25.0}, 10.0);
  EXPECT_EQ(chosen.settings.options.method, ViewMethod::kHlfVd);
  EXPECT_THAT(chosen.reason, AllOf(HasSubstr("36.00 dB at 20 ms"), HasSubstr("within 25 ms"),
                                   HasSubstr("37.00 dB would take 40 ms (two-sided)")));
  EXPECT_EQ(choose_setting(some_trade(), {.budget_ms = 1e6}, 10.0).settings.options.method,
            ViewMethod::kTwoSided);
}

TEST(MeasuredChoiceTest, ASlowerMachineGetsAFasterSetting) {
  EXPECT_EQ(choose_setting(some_trade(), {.budget_ms = 25.0}, 5.0).settings.options.method,
            ViewMethod::kTwoSided);
  EXPECT_EQ(choose_setting(some_trade(), {.budget_ms = 25.0}, 40.0).settings.options.method,
            ViewMethod::kInitial);
}

TEST(MeasuredChoiceTest, ChoosesTheFastestThatReachesThePsnr) {
  const Preset chosen = choose_setting(some_trade(), {.min_psnr_db = 35.5}, 10.0);
  EXPECT_EQ(chosen.settings.options.method, ViewMethod::kHlfVd);
  EXPECT_THAT(chosen.reason, HasSubstr("the fastest with at least 35.5 dB"));
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
  DemandedSettingsTest() {
    write_synthetic_room({.width = 32}, path_);
    room_ = Room::open(path_);
  }
  std::string message(const Demand& demand) {
    return error_of([&] { demanded_settings({}, demand, room_); });
  }
  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
  Room room_;
};

TEST_F(DemandedSettingsTest, ComeFromTheRoomsTradeWithFlagsOnTop) {
  write_measured_settings(path_, one_setting(distances_sha256(room_)));
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
  write_measured_settings(path_, one_setting(distances_sha256(room_)));
  ViewFlags flags;
  flags.parameters["k_deg"] = "76.5";
  EXPECT_EQ(demanded_settings(flags, {.min_psnr_db = 25.0}, room_).k_source, "");
  flags.parameters["k_deg"] = "80";
  EXPECT_EQ(demanded_settings(flags, {.min_psnr_db = 25.0}, room_).k_source, "");
  flags.parameters.clear();
  flags.connection = "lfu";
  EXPECT_EQ(demanded_settings(flags, {.min_psnr_db = 25.0}, room_).k_source, "");
}

// Without work, the remap takes as long as the clock says: a hiccup and the warm-up do not count.
TEST_F(DemandedSettingsTest, TheRemapIsTimedOnThisMachine) {
  write_measured_settings(path_, one_setting(distances_sha256(room_)));
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
  write_measured_settings(path_, one_setting("other"));
  EXPECT_THAT(message({.budget_ms = 1e6}),
              AllOf(HasSubstr("measured.json: "), HasSubstr("other distances")));
}

}  // namespace
}  // namespace raywalk::render
