#include "core/judge/trade/trade.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv_records.h"
#include "core/judge/trade/measured_settings.h"
#include "core/judge/trade/trade_test_room.h"
#include "core/judge/validation/connect_error.h"
#include "core/room/requirements.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
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
  EXPECT_THAT(read_file(options_.timing_lock),
              HasSubstr("(raywalk-render trade " + room_.directory().string() + ")"));
  const json all = written();
  EXPECT_EQ(all["format_version"], 4);
  EXPECT_EQ(all["room"], room_.directory().string());
  EXPECT_EQ(all["views"].size(), 2U);
  EXPECT_EQ(all["width_px"], 64);
  EXPECT_GE(all["machine"]["threads"], 1);
  EXPECT_GT(all["remap_ms"], 0.0);
  EXPECT_GT(all["settings"].size(), 15U);
  const json& first = all["settings"][0];
  EXPECT_EQ(keys_of(first), (std::set<std::string>{"number",
                                                   "name",
                                                   "generation",
                                                   "k_deg",
                                                   "overlap_deg",
                                                   "width_px",
                                                   "interpolation",
                                                   "stations_mixed",
                                                   "station_fade",
                                                   "distance_maps",
                                                   "second_side",
                                                   "threads",
                                                   "stored_width_px",
                                                   "depth",
                                                   "compression",
                                                   "rays_mb",
                                                   "ms",
                                                   "ratio",
                                                   "cpu_ratio",
                                                   "remap_ms",
                                                   "remap_spread",
                                                   "others_share",
                                                   "disturbed",
                                                   "peak_mb",
                                                   "mapped_mb",
                                                   "psnr_db",
                                                   "ws_psnr_db",
                                                   "ssim",
                                                   "fsim",
                                                   "held_out_psnr_db",
                                                   "held_out_ws_psnr_db",
                                                   "held_out_ssim",
                                                   "held_out_fsim",
                                                   "e_connect",
                                                   "pareto"}));
  EXPECT_EQ(first["number"], 1);
  EXPECT_EQ(keys_of(first["pareto"]),
            (std::set<std::string>{"psnr_db", "ws_psnr_db", "ssim", "fsim", "e_connect"}));
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
    EXPECT_EQ(setting["pareto"]["e_connect"], false);
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
      const bool front = key.starts_with("pareto_");
      const json value = front ? settings[i]["pareto"][key.substr(7)] : settings[i][key];
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
    EXPECT_GE(compared, 15U);
  }
}

TEST_F(TradeTest, TheReportShowsTheErrorsOfSettings) {
  write_trade(few(), options_.report);
  const std::string page = read_file(options_.report / "index.html");
  EXPECT_THAT(page, AllOf(HasSubstr("\"kind\":\"trade\""), HasSubstr("error, times 4"),
                          HasSubstr("data:image/jpeg")));
  for (int i = 1; i <= 5; ++i) EXPECT_THAT(page, HasSubstr(fmt::format("setting {}: ", i)));
}

TEST_F(TradeTest, OtherRoomsAreSweptAsFurtherSettings) {
  write_synthetic_room({.overhang_m = 0.25, .width = 32}, directory_ / "small.lf");
  write_synthetic_room({.overhang_m = 0.25, .width = 64}, directory_ / "same.lf");
  write_synthetic_room(
      {.overhang_m = 0.25, .width = 64, .form = {RayForm::Kind::kJpeg, 90}, .tile_columns = 64},
      directory_ / "tiled.lf");
  options_.centres = {mode(Generation::kInitial)};
  options_.also = {directory_ / "small.lf", directory_ / "same.lf", directory_ / "tiled.lf"};
  trade(room_, options_);
  std::set<std::string> names;
  const json all = written();
  for (const json& setting : all["settings"]) names.insert(setting["name"]);
  EXPECT_THAT(names, Contains("initial, stored 32 px wide, depth given, 32 px"));
  EXPECT_THAT(names, Contains("initial, depth given, 64 px, " + (directory_ / "same.lf").string()));
  EXPECT_EQ(all["rooms"].size(), 4U);
  // A compressed room differs in its size: one dial more.
  EXPECT_THAT(names, Contains("initial, compression jpeg:90"));
  EXPECT_EQ(all["rooms"][3]["compression"], "jpeg:90");
  for (const json& setting : all["settings"]) {
    const bool tiled = setting["compression"] == "jpeg:90";
    EXPECT_EQ(setting["rays_mb"] == all["rooms"][3]["rays_mb"], tiled);
  }
  EXPECT_LT(all["rooms"][3]["rays_mb"], all["rooms"][0]["rays_mb"]);
}

TEST_F(TradeTest, ARoomWithoutDistancesIsSweptInitialWithANote) {
  make_room({.overhang_m = 0.25, .width = 64, .distances = false});
  options_.centres = {mode(Generation::kInitial)};
  EXPECT_THAT(trade(room_, options_), HasSubstr("no distances"));
  EXPECT_EQ(written()["rooms"][0]["depth"], "none");
  // It is stored in the room, for choosing views.
  EXPECT_EQ(written()["distances_sha256"], distances_sha256(room_));
  const json all = written();
  EXPECT_FALSE(all["settings"].empty());
  for (const json& setting : all["settings"]) EXPECT_EQ(setting["generation"], "initial");
}

// Measurements of other rooms are no measurements of this one.
TEST_F(TradeTest, TheRoomKeepsItsOwnSettingsOnly) {
  TradeInput both = few();
  write_synthetic_room({.overhang_m = 0.25, .width = 32}, directory_ / "small.lf");
  const Room small = Room::open(directory_ / "small.lf");
  both.rooms.push_back(trade_room(small, both.rooms[0].views));
  both.settings[1].room = 1;
  both.settings[1].stored_width_px = 32;
  write_trade(both, options_.report);
  std::vector<std::string> names;
  const auto stored = read_measured_settings(room_.directory());
  ASSERT_TRUE(stored);
  for (const MeasuredChoice& choice : stored->settings.choices) {
    names.push_back(choice.name);
  }
  EXPECT_THAT(names, ::testing::ElementsAre("setting 0", "setting 2", "setting 3", "setting 4"));
}

TEST_F(TradeTest, ASingleLineHasNoConnectionError) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  list("near.png,0,0,-0.25\n");
  write_trade(input({{.generation = Generation::kInitial, .k_deg = 90.0}}), options_.report);
  EXPECT_TRUE(written()["settings"][0]["e_connect"].is_null());
  EXPECT_EQ(written()["settings"][0]["pareto"]["e_connect"], false);
}

TEST_F(TradeTest, RefusesBadInputBeforeAnyWork) {
  list("gone.png,0,0,0\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("gone.png")));
  list("near.png,9,0,0\n");
  EXPECT_THAT(run_error(), HasSubstr("gt.csv:2"));
  list("near.png,0.4,0,0\n");
  options_.also = {directory_ / "none.lf"};
  EXPECT_THAT(run_error(), HasSubstr("none.lf"));
  write_synthetic_room({.side_m = 1.25, .width = 64}, directory_ / "elsewhere.lf");
  options_.also = {directory_ / "elsewhere.lf"};
  EXPECT_THAT(run_error(), AllOf(HasSubstr("elsewhere.lf"), HasSubstr("--also")));
  EXPECT_FALSE(fs::exists(options_.report));
  options_.also.clear();
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
}

}  // namespace
}  // namespace raywalk
