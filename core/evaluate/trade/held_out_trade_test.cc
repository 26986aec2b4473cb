#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/evaluate/trade/measured_settings.h"
#include "core/evaluate/trade/trade.h"
#include "core/evaluate/trade/trade_test_room.h"
#include "core/room/requirements.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
using nlohmann::json;

class HeldOutTradeTest : public TradeTest {
 protected:
  HeldOutTradeTest() {
    make_room({.spacing_m = 0.0625, .overhang_m = 0.25, .width = 64});
    options_.held_out = 4;
    options_.presets = {{"plain", "it is central", mode(Generation::kHlfVd)},
                        {"own", "it is not", {.options = {.k_deg = 55.0, .stations_mixed = 7}}}};
  }
};

TEST_F(HeldOutTradeTest, StationsReplaceTrueViews) {
  options_.truth.clear();
  const std::string said = trade(room_, options_);
  EXPECT_THAT(said, HasSubstr("preset own"));
  const json trade = written();
  EXPECT_EQ(trade["truth"], "one of 4 stations, held out");
  EXPECT_FALSE(trade["views"].empty());
  const json& settings = trade["settings"];
  EXPECT_GT(settings[1]["psnr_db"], settings[0]["psnr_db"]) << "corrected views are better";
  ASSERT_EQ(trade["presets"].size(), 2U);
  const auto named = [&](int preset) {
    return settings[trade["presets"][preset]["number"].get<std::size_t>() - 1]["name"];
  };
  EXPECT_EQ(named(0), "hlf-vd");
  EXPECT_EQ(named(1), "preset own");
  EXPECT_EQ(trade["presets"][1]["reason"], "it is not");
  // The room keeps all but the settings on one thread.
  const auto stored = read_measured_settings(room_.directory());
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->settings.distances_sha256, distances_sha256(room_));
  EXPECT_EQ(stored->settings.width_px, 64);
  const auto own = std::ranges::count(settings, trade["machine"]["threads"],
                                      [](const json& setting) { return setting["threads"]; });
  EXPECT_EQ(std::ssize(stored->settings.choices), own);
  const MeasuredChoice& last = stored->settings.choices.back();
  EXPECT_EQ(last.name, "preset own");
  EXPECT_EQ(last.options.stations_mixed, 7);
  EXPECT_EQ(last.psnr_db, settings.back()["psnr_db"]);
  EXPECT_EQ(last.ratio, settings.back()["ratio"]);
}

TEST_F(HeldOutTradeTest, NeedsTruthOrHeldOutStations) {
  EXPECT_THAT(run_error(), HasSubstr("one of both"));
  options_.truth.clear();
  options_.held_out = 0;
  EXPECT_THAT(run_error(), HasSubstr("with --truth, or use stations"));
}

}  // namespace
}  // namespace raywalk
