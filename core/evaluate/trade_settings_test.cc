#include "core/evaluate/trade_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

namespace raywalk {
namespace {

using nlohmann::ordered_json;
using testing::SizeIs;

class TradeSweepTest : public ::testing::Test {
 protected:
  TradeSweepTest() {
    for (const ViewMethod method :
         {ViewMethod::kInitial, ViewMethod::kHlfVd, ViewMethod::kTwoSided}) {
      centres_.push_back({.method = method, .k_deg = 80.0});
    }
  }
  std::vector<ViewOptions> centres_;
};

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

TEST_F(TradeSweepTest, SettingsAreUnique) {
  const std::vector<TradeSetting> sweep = trade_sweep(centres_, 64, 2);
  std::set<std::string> parameters;
  for (const TradeSetting& setting : sweep) parameters.insert(parameters_of(setting).dump());
  EXPECT_EQ(parameters.size(), sweep.size());
  EXPECT_EQ(names(sweep).size(), sweep.size());
}

TEST_F(TradeSweepTest, EveryParameterIsVaried) {
  const auto taken = values(trade_sweep(centres_, 64, 2));
  for (const auto& [parameter, all] : taken) EXPECT_GE(all.size(), 2U) << parameter;
  EXPECT_THAT(taken.at("stations_mixed"), SizeIs(5));
  EXPECT_THAT(taken.at("k_deg"), SizeIs(4));  // the central one too
  EXPECT_THAT(taken.at("overlap_deg"), SizeIs(3));
}

// A parameter without effect would give the same image in the same time under another name.
TEST_F(TradeSweepTest, ParametersWithoutEffectAreNotVaried) {
  EXPECT_THAT(trade_sweep(std::span(centres_).first(1), 64, 2), SizeIs(1)) << "initial views";
  EXPECT_THAT(values(trade_sweep(std::span(centres_).subspan(1, 1), 64, 2)).at("second_side"),
              SizeIs(1));
}

TEST_F(TradeSweepTest, NamesListDifferencesFromTheCentre) {
  const std::set<std::string> sweep = names(trade_sweep(centres_, 64, 2));
  for (const char* name : {"hlf-vd", "two-sided", "hlf-vd, cubic", "hlf-vd, k 45°",
                           "hlf-vd, stations 16", "hlf-vd, threads 1", "hlf-vd, 32 px wide",
                           "two-sided, cubic, stations 8, second side faded"}) {
    EXPECT_TRUE(sweep.contains(name)) << name;
  }
}

}  // namespace
}  // namespace raywalk
