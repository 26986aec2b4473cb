#include "core/evaluate/trade/trade.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/evaluate/trade/measured_settings.h"
#include "core/evaluate/trade/trade_test_room.h"
#include "core/evaluate/validation/connect_error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv_records.h"
#include "core/room/requirements.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;
using nlohmann::json;

std::set<std::string> keys_of(const json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

TEST_F(TradeTest, WritesTheDocumentedFiles) {
  const std::string said = trade(room_, options_);
  EXPECT_THAT(said, AllOf(HasSubstr("PSNR"), HasSubstr("index.html")));
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(options_.report)) {
    files.insert(entry.path().filename().string());
  }
  EXPECT_EQ(files, (std::set<std::string>{"index.html", "trade.csv", "trade.json"}));
  const json all = written();
  EXPECT_EQ(all["format_version"], 5);
  EXPECT_EQ(all["room"], room_.directory().string());
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["views"].size(), 2U);
  EXPECT_EQ(all["width_px"], 64);
  EXPECT_GE(all["machine"]["threads"], 1);
  EXPECT_GT(all["remap_ms"], 0.0);
  EXPECT_GT(all["settings"].size(), 15U);
  EXPECT_EQ(
      keys_of(all["settings"][0]),
      (std::set<std::string>{"number",       "name",          "generation",    "k_deg",
                             "overlap_deg",  "width_px",      "interpolation", "stations_mixed",
                             "station_fade", "distance_maps", "second_side",   "threads",
                             "ms",           "ratio",         "remap_ms",      "remap_spread",
                             "psnr_db",      "ws_psnr_db",    "ssim",          "fsim",
                             "e_connect",    "on_front"}));
}

// No other setting is at least as fast and as good, and better in one.
TEST_F(TradeTest, TheFrontIsWhatNothingElseDominates) {
  write_trade(few(), options_.report);
  const json settings = written()["settings"];
  int on_front = 0;
  for (const json& setting : settings) {
    bool dominated = false;
    for (const json& other : settings) {
      dominated = dominated ||
                  (other["ratio"] < setting["ratio"] && other["psnr_db"] >= setting["psnr_db"]);
    }
    EXPECT_EQ(setting["on_front"], !dominated) << setting["name"];
    on_front += dominated ? 0 : 1;
  }
  EXPECT_GE(on_front, 1);
  EXPECT_LT(on_front, 5);
}

// Times are less certain then, but chosen by all the same.
TEST_F(TradeTest, ABusyMachineIsNamedOnce) {
  EXPECT_THAT(write_trade(few(), options_.report), Not(HasSubstr("busy")));
  EXPECT_EQ(written()["busy"], false);
  clock_.busy = true;
  EXPECT_THAT(write_trade(few(), options_.report), HasSubstr("other programs were busy"));
  EXPECT_EQ(written()["busy"], true);
  EXPECT_EQ(read_measured_settings(room_.directory())->settings.choices.size(), 5U);
}

TEST_F(TradeTest, NumbersItsSettingsAndNamesTheParameters) {
  trade(room_, options_);
  const json all = written();
  EXPECT_EQ(all["pictured_view"], "middle");
  for (std::size_t i = 0; i < all["settings"].size(); ++i) {
    EXPECT_EQ(all["settings"][i]["number"], i + 1);
  }
  EXPECT_EQ(all["parameters"][0]["key"], "generation");
  EXPECT_EQ(all["parameters"][0]["default"], "hlf-vd");
  EXPECT_TRUE(all["presets"].empty());
}

TEST_F(TradeTest, ScoresAreThoseOfTheViews) {
  write_trade(few(), options_.report);
  const json settings = written()["settings"];
  std::vector<ViewScores> scores;
  for (const auto& [name, at] :
       {std::pair("near.png", PlanPoint{0.4, 0.0}), std::pair("middle.png", PlanPoint{0.0, 0.1})}) {
    const cv::Mat view = Renderer(room_, {.k_deg = 45.0, .stations_mixed = 4}).render(at).image;
    scores.push_back(score_view(view, read_panorama(directory_ / name)));
  }
  EXPECT_NEAR(settings[2]["psnr_db"].get<double>(), mean_of(scores).psnr_db, 1e-9);
  EXPECT_NEAR(settings[2]["fsim"].get<double>(), mean_of(scores).fsim, 1e-9);
  // Corrected is better than initial, as wide as the truth better than half.
  EXPECT_GT(settings[1]["psnr_db"], settings[0]["psnr_db"]);
  EXPECT_GT(settings[1]["psnr_db"], settings[3]["psnr_db"]);
  EXPECT_GT(settings[3]["psnr_db"], 10.0);
}

// E_connect belongs to a generation and its k, and not to the other parameters.
TEST_F(TradeTest, ConnectionErrorsAreThoseOfGenerationAndK) {
  make_room({.overhang_m = 0.25, .width = 128});
  write_trade(few(), options_.report);
  const json settings = written()["settings"];
  const ConnectError measured = measure_connect_error(
      room_, Generation::kHlfVd, {.viewpoints = 2, .k_list_deg = {45.0, 90.0}});
  ASSERT_GE(measured.common_share, 0.5);
  EXPECT_EQ(settings[2]["e_connect"], measured.rows[0].e_connect_common);
  EXPECT_EQ(settings[1]["e_connect"], measured.rows[1].e_connect_common);
  EXPECT_EQ(settings[3]["e_connect"], settings[1]["e_connect"]);
  EXPECT_NE(settings[0]["e_connect"], settings[1]["e_connect"]);
}

// Unlike k would be compared over unlike corners.
TEST_F(TradeTest, ConnectionErrorsOverTooFewCommonCornersAreNotGiven) {
  make_room({.overhang_m = 0.02, .width = 128});
  const ConnectError measured = measure_connect_error(
      room_, Generation::kInitial, {.viewpoints = 2, .k_list_deg = {45.0, 90.0}});
  ASSERT_GT(measured.common_share, 0.0);
  ASSERT_LT(measured.common_share, kLeastCommonShare);
  write_trade(few(), options_.report);
  const json settings = written()["settings"];
  ASSERT_EQ(settings.size(), 5U);
  for (const json& setting : settings) {
    EXPECT_TRUE(setting["e_connect"].is_null()) << setting["name"];
  }
}

TEST_F(TradeTest, TheTableHoldsTheNumbersOfTheJson) {
  write_trade(few(), options_.report);
  const auto records = split_csv(read_file(options_.report / "trade.csv"), "trade.csv");
  const json settings = written()["settings"];
  ASSERT_EQ(records.size(), settings.size() + 1);
  const std::vector<std::string>& header = records[0].fields;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const std::vector<std::string>& row = records[i + 1].fields;
    ASSERT_EQ(row.size(), header.size());
    std::size_t compared = 0;
    for (std::size_t column = 0; column < header.size(); ++column) {
      const std::string& key = header[column];
      const json& value = settings[i][key];
      if (value.is_null()) {
        EXPECT_EQ(row[column], "") << key;
      } else if (value.is_boolean()) {
        EXPECT_EQ(row[column], value.get<bool>() ? "1" : "0") << key;
      } else if (value.is_string()) {
        EXPECT_EQ(row[column], value.get<std::string>()) << key;
      } else {
        EXPECT_EQ(std::stod(row[column]), value.get<double>()) << key;
        ++compared;
      }
    }
    EXPECT_GE(compared, 12U);
  }
}

TEST_F(TradeTest, TheReportShowsTheErrorsOfSettings) {
  write_trade(few(), options_.report);
  const std::string page = read_file(options_.report / "index.html");
  EXPECT_THAT(page, AllOf(HasSubstr("\"kind\":\"trade\""), HasSubstr("error, times 4"),
                          HasSubstr("data:image/jpeg")));
  for (int i = 1; i <= 5; ++i) EXPECT_THAT(page, HasSubstr(fmt::format("setting {}: ", i)));
}

TEST_F(TradeTest, ARoomWithoutDistancesIsSweptInitialWithANote) {
  make_room({.overhang_m = 0.25, .width = 64, .distances = false});
  options_.centres = {mode(Generation::kInitial)};
  EXPECT_THAT(trade(room_, options_), HasSubstr("no distances"));
  EXPECT_EQ(written()["distances"], "none");
  // It is stored in the room, for choosing views.
  EXPECT_EQ(written()["distances_sha256"], distances_sha256(room_));
  const json all = written();
  EXPECT_FALSE(all["settings"].empty());
  for (const json& setting : all["settings"]) EXPECT_EQ(setting["generation"], "initial");
}

TEST_F(TradeTest, ASingleLineHasNoConnectionError) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  list("near.png,0,0,-0.25\n");
  write_trade(input({{.generation = Generation::kInitial, .k_deg = 90.0}}), options_.report);
  EXPECT_TRUE(written()["settings"][0]["e_connect"].is_null());
}

TEST_F(TradeTest, RefusesBadInputBeforeAnyWork) {
  list("gone.png,0,0,0\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("gone.png")));
  list("near.png,9,0,0\n");
  EXPECT_THAT(run_error(), HasSubstr("gt.csv:2"));
  list("near.png,0.4,0,0\n");
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
}

}  // namespace
}  // namespace raywalk
