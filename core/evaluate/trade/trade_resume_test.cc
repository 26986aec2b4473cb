#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/evaluate/trade/measured_settings.h"
#include "core/evaluate/trade/trade.h"
#include "core/evaluate/trade/trade_test_room.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
using nlohmann::json;

// Without values that depend on the clock.
json timeless(json trade) {
  for (const char* key : {"remap_ms", "busy"}) trade.erase(key);
  for (json& setting : trade["settings"]) {
    for (const char* key : {"ms", "ratio", "remap_ms", "remap_spread", "on_front"}) {
      setting.erase(key);
    }
  }
  return trade;
}

TEST_F(TradeTest, ResumesAnInterruptedRun) {
  const TradeInput all = few();
  write_trade(all, options_.report);
  const json whole = written();
  TradeInput begun = all;
  begun.settings.resize(2);
  measure_trade(begun, partial());
  const json kept = json::parse(read_file(partial()));
  ASSERT_EQ(kept["settings"].size(), 2U);
  write_trade(all, options_.report);
  EXPECT_EQ(timeless(written()), timeless(whole));
  // Settings measured before the interruption were not measured again.
  std::set<double> times_ms;
  for (const json& setting : kept["settings"]) {
    times_ms.insert(setting["measured"]["ms"].get<double>());
  }
  for (int i : {0, 1}) EXPECT_TRUE(times_ms.contains(written()["settings"][i]["ms"].get<double>()));
  EXPECT_FALSE(fs::exists(partial()));
}

TEST_F(TradeTest, DamagedPartialNumbersAreRefused) {
  const TradeInput all = few();
  fs::create_directories(options_.report);
  measure_trade(all, partial());
  json kept = json::parse(read_file(partial()));
  kept["settings"][1]["measured"]["ratio"] = "fast";
  write_file_atomically(partial(), kept.dump());
  try {
    measure_trade(all, partial());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("settings[1]: measured: ratio: \"fast\" is not a number"));
  }
}

TEST_F(TradeTest, NeverMixesInputs) {
  const TradeInput all = few();
  fs::create_directories(options_.report);
  measure_trade(all, partial());
  TradeInput other = all;
  other.repetitions = 2;
  EXPECT_THROW(measure_trade(other, partial()), Error);
  other = all;
  other.views[0].truth = ~other.views[0].truth;
  EXPECT_THROW(measure_trade(other, partial()), Error);
  std::ofstream(partial()) << "{";
  EXPECT_THROW(measure_trade(all, partial()), Error);
}

}  // namespace
}  // namespace raywalk
