#include "core/judge/trade/trade_sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/files/test_directory.h"
#include "core/judge/trade/captured_views.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;
using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

class TradeSweepTest : public ::testing::Test {
 protected:
  TradeSweepTest() {
    for (const Generation generation :
         {Generation::kInitial, Generation::kHlfVd, Generation::kTwoSided}) {
      base_.centres.push_back({.options = {.generation = generation, .k_deg = 80.0}});
    }
    base_.width_px = 64;
    base_.threads = 2;
  }

  void add_room(const std::string& name, const SyntheticRoomSpec& spec) {
    write_synthetic_room(spec, directory_ / name);
    opened_.push_back(std::make_unique<Room>(Room::open(directory_ / name)));
    rooms_.push_back({.room = opened_.back().get(), .depth = depth_name(*opened_.back())});
    base_.rooms = rooms_;
  }
  void add_two_rooms() {
    add_room("room.lf", {.width = 64});
    add_room("wide.lf", {.width = 128, .distance_width = 32});
  }

  TestDirectory directory_;
  std::vector<std::unique_ptr<Room>> opened_;
  std::vector<TradeRoom> rooms_;
  SweepBase base_;
};

std::set<std::string> parameter_texts(const std::vector<TradeSetting>& settings) {
  std::set<std::string> texts;
  for (const TradeSetting& setting : settings) texts.insert(parameters_of(setting).dump());
  return texts;
}

std::set<std::string> names(const std::vector<TradeSetting>& settings) {
  std::set<std::string> names;
  for (const TradeSetting& setting : settings) names.insert(setting.name);
  return names;
}

// The values that every parameter takes.
std::map<std::string, std::set<std::string>> values(const std::vector<TradeSetting>& settings) {
  std::map<std::string, std::set<std::string>> values;
  for (const TradeSetting& setting : settings) {
    const ordered_json parameters = parameters_of(setting);
    for (const auto& [parameter, value] : parameters.items())
      values[parameter].insert(value.dump());
  }
  return values;
}

std::vector<TradeSetting> of_generation(const std::vector<TradeSetting>& settings,
                                        Generation generation) {
  std::vector<TradeSetting> found;
  for (const TradeSetting& setting : settings) {
    if (setting.mode.options.generation == generation) found.push_back(setting);
  }
  return found;
}

TEST_F(TradeSweepTest, SettingsAreUnique) {
  add_two_rooms();
  for (const auto& sweep : {quick_sweep(base_), full_sweep(base_)}) {
    EXPECT_EQ(parameter_texts(sweep).size(), sweep.size());
    EXPECT_EQ(names(sweep).size(), sweep.size());
  }
}

TEST_F(TradeSweepTest, EveryParameterIsVaried) {
  add_two_rooms();
  for (const auto& [parameter, taken] : values(quick_sweep(base_))) {
    if (parameter == "compression") continue;  // both rooms are stored alike
    EXPECT_GE(taken.size(), 2U) << parameter;
  }
  const auto full = values(full_sweep(base_));
  EXPECT_THAT(full.at("interpolation"), SizeIs(2));
  EXPECT_THAT(full.at("stations_mixed"), SizeIs(5));
  EXPECT_THAT(full.at("k_deg"), SizeIs(4));  // the central one too
  EXPECT_THAT(full.at("overlap_deg"), SizeIs(3));
  EXPECT_THAT(full.at("threads"), SizeIs(2));
}

TEST_F(TradeSweepTest, TheFullSweepHoldsTheQuickOneAndCombinations) {
  add_two_rooms();
  const std::set<std::string> quick = parameter_texts(quick_sweep(base_));
  const std::vector<TradeSetting> full = full_sweep(base_);
  EXPECT_TRUE(std::ranges::includes(parameter_texts(full), quick));
  // The combination farthest from the centre in both grids.
  const bool samples = std::ranges::any_of(full, [](const TradeSetting& setting) {
    const ViewOptions& o = setting.mode.options;
    return o.generation == Generation::kTwoSided && o.interpolation == Interpolation::kCubic &&
           o.stations_mixed == 8 && o.second_side == SecondSide::kFaded && o.distance_maps == 1;
  });
  const bool layout = std::ranges::any_of(full, [](const TradeSetting& setting) {
    const ViewOptions& o = setting.mode.options;
    return o.generation == Generation::kHlfVd && o.k_deg == 45.0 && o.overlap_deg == 15.0 &&
           o.width == 32 && setting.threads == 1;
  });
  EXPECT_TRUE(samples);
  EXPECT_TRUE(layout);
}

// A parameter without effect would give the same picture in the same time under another name.
TEST_F(TradeSweepTest, ParametersWithoutEffectAreNotVaried) {
  add_room("room.lf", {.width = 64});
  const std::vector<TradeSetting> full = full_sweep(base_);
  const auto initial = values(of_generation(full, Generation::kInitial));
  for (const char* parameter :
       {"stations_mixed", "distance_maps", "second_side", "interpolation"}) {
    EXPECT_THAT(initial.at(parameter), SizeIs(1)) << parameter;
  }
  EXPECT_THAT(initial.at("k_deg"), SizeIs(4));
  EXPECT_THAT(values(of_generation(full, Generation::kHlfVd)).at("second_side"), SizeIs(1));
}

TEST_F(TradeSweepTest, InitialViewsBetweenCapturedColumnsAreInterpolated) {
  add_room("room.lf", {.width = 96});
  const auto initial = values(of_generation(full_sweep(base_), Generation::kInitial));
  EXPECT_THAT(initial.at("interpolation"), SizeIs(2));
}

TEST_F(TradeSweepTest, ARoomWithoutDistancesHasInitialSettingsOnly) {
  add_room("room.lf", {.width = 64});
  add_room("bare.lf", {.width = 128, .distances = false});
  std::vector<TradeSetting> bare;
  for (const TradeSetting& setting : full_sweep(base_)) {
    if (setting.room == 1) bare.push_back(setting);
  }
  EXPECT_FALSE(bare.empty());
  EXPECT_EQ(of_generation(bare, Generation::kInitial).size(), bare.size());
}

TEST_F(TradeSweepTest, OneCoreGivesOneNumberOfThreads) {
  add_room("room.lf", {.width = 64});
  base_.threads = 1;
  EXPECT_THAT(values(full_sweep(base_)).at("threads"), SizeIs(1));
}

TEST_F(TradeSweepTest, NamesListDifferencesFromTheCentre) {
  add_two_rooms();
  const std::set<std::string> quick = names(quick_sweep(base_));
  for (const char* name : {"hlf-vd", "two-sided", "hlf-vd, cubic", "hlf-vd, k 45°",
                           "hlf-vd, stations 16", "hlf-vd, threads 1"}) {
    EXPECT_TRUE(quick.contains(name)) << name;
  }
  EXPECT_TRUE(quick.contains("hlf-vd, stored 128 px wide, depth given, 32 px"));
}

}  // namespace
}  // namespace raywalk
