#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/judge/trade/measured_settings.h"
#include "core/judge/trade/trade.h"
#include "core/judge/trade/trade_test_room.h"
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

TEST_F(HeldOutTradeTest, RanksSettingsWithTheTruthAndStoresThemInTheRoom) {
  const std::string said = trade(room_, options_);
  EXPECT_THAT(said, AllOf(HasSubstr("rank correlation"), HasSubstr("preset own")));
  const json trade = written();
  const auto stored = read_measured_settings(room_.directory());
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->settings.distances_sha256, distances_sha256(room_));
  EXPECT_EQ(stored->settings.width_px, 64);
  // All but the settings on one thread.
  const auto own = std::ranges::count(trade["settings"], trade["machine"]["threads"],
                                      [](const json& setting) { return setting["threads"]; });
  EXPECT_EQ(std::ssize(stored->settings.choices), own);
  EXPECT_EQ(stored->settings.choices.back().name, "preset own");
  EXPECT_EQ(stored->settings.choices.back().options.stations_mixed, 7);
  EXPECT_EQ(stored->settings.choices.back().psnr_db, trade["settings"].back()["psnr_db"]);
  EXPECT_EQ(stored->settings.choices.back().ratio, trade["settings"].back()["ratio"]);
  EXPECT_EQ(trade["distances_sha256"], distances_sha256(room_));
  EXPECT_FALSE(trade["held_out_views"].empty());
  // Without correction, or with little, both show the same loss.
  EXPECT_GT(trade["rank_correlation"]["psnr_db"], 0.3);
  for (const json& setting : trade["settings"]) {
    EXPECT_GT(setting["held_out_psnr_db"], 5.0) << setting["name"];
  }
  ASSERT_EQ(trade["presets"].size(), 2U);
  const auto named = [&](int preset) {
    return trade["settings"][trade["presets"][preset]["number"].get<std::size_t>() - 1]["name"];
  };
  EXPECT_EQ(named(0), "hlf-vd");
  EXPECT_EQ(named(1), "preset own");
  EXPECT_EQ(trade["presets"][1]["reason"], "it is not");
  EXPECT_EQ(trade["settings"].back()["stations_mixed"], 7);
}

TEST_F(HeldOutTradeTest, WorksWithoutTruth) {
  options_.truth.clear();
  trade(room_, options_);
  const json trade = written();
  EXPECT_EQ(trade["truth"], "one of 4 stations, held out");
  EXPECT_TRUE(trade["rank_correlation"].is_null());
  EXPECT_FALSE(trade["views"].empty());
  EXPECT_TRUE(trade["settings"][0]["held_out_psnr_db"].is_null());
  EXPECT_GT(trade["settings"][1]["psnr_db"], trade["settings"][0]["psnr_db"]);
}

TEST_F(HeldOutTradeTest, NeedsTruthOrHeldOutStations) {
  options_.truth.clear();
  options_.held_out = 0;
  EXPECT_THAT(run_error(), HasSubstr("with --truth, or use stations"));
  options_.held_out = 4;
  options_.also = {directory_ / "room.lf"};
  EXPECT_THAT(run_error(), HasSubstr("--also needs --truth without --held-out"));
}

}  // namespace
}  // namespace raywalk
