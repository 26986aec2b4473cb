#include "core/evaluate/trade.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/interrupt.h"
#include "core/evaluate/test_truths.h"
#include "core/evaluate/trade_settings.h"
#include "core/evaluate/truth_views.h"
#include "core/files/csv.h"
#include "core/files/test_support.h"
#include "core/room/requirements.h"
#include "core/view/renderer.h"

namespace raywalk {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using testing::SizeIs;

// Of two views timed once: each to warm up and to be timed, the remap beside each and once before.
constexpr int kWorksOfASetting = 7;

class TradeTest : public TruthTest {
 protected:
  TradeTest() {
    options_.truth = truth_;
    options_.report = report_;
    options_.repetitions = 1;
    options_.time_source = [this](const std::function<void()>& work) {
      work();
      if (works_++ == interrupted_at_) throw Interrupted("now");
      // Every work takes the next millisecond more, so that all times differ and are steady; or, if
      // busy, sometimes three times as long.
      taken_s_ += 1e-6;
      return busy_ && works_ % 3 != 0 ? 3.0 * taken_s_ : taken_s_;
    };
    // A few settings only, for speed.
    for (const ViewOptions& options :
         {ViewOptions{.method = ViewMethod::kInitial}, ViewOptions{},
          ViewOptions{.k_deg = 45.0, .stations_mixed = 4}, ViewOptions{.k_deg = 70.0},
          ViewOptions{.method = ViewMethod::kTwoSided}}) {
      options_.presets.push_back(
          {std::to_string(options_.presets.size()), "it is measured", options});
    }
  }
  void sweep(std::vector<ViewMethod> methods) {
    options_.presets.clear();
    for (const ViewMethod method : methods) {
      options_.centres.push_back({.method = method, .k_deg = 80.0});
    }
  }
  // The trade that a run writes, and what it says.
  json traded() {
    said_ = trade(room_, options_);
    return json_in(report_ / "trade.json");
  }
  std::string run_error() const {
    return error_of([&] { trade(room_, options_); });
  }

  TradeOptions options_;
  std::string said_;
  bool busy_ = false;
  double taken_s_ = 1.0;
  int works_ = 0, interrupted_at_ = -1;
};

TEST_F(TradeTest, WritesTheDocumentedFiles) {
  sweep({ViewMethod::kInitial, ViewMethod::kHlfVd});
  const json all = traded();
  EXPECT_THAT(said_, AllOf(HasSubstr("PSNR"), HasSubstr("index.html")));
  EXPECT_EQ(files(), (std::set<std::string>{"index.html", "trade.csv", "trade.json"}));
  EXPECT_EQ(all["format_version"], 7);
  EXPECT_EQ(all["room"], room_.directory().string());
  EXPECT_EQ(all["truth"], truth_.string());
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["views"].size(), 2U);
  EXPECT_EQ(all["width_px"], 64);
  EXPECT_GE(all["machine"]["threads"], 1);
  EXPECT_GT(all["remap_ms"], 0.0);
  EXPECT_GT(all["settings"].size(), 15U);
  EXPECT_EQ(all["settings"][1]["number"], 2);
  EXPECT_EQ(all["parameters"][0]["key"], "method");
  EXPECT_EQ(all["parameters"][0]["default"], "hlf-vd");
  EXPECT_EQ(keys_of(all["settings"][0]),
            (std::set<std::string>{
                "number",      "name",          "method",         "k_deg",        "overlap_deg",
                "width_px",    "interpolation", "stations_mixed", "station_fade", "distance_maps",
                "second_side", "threads",       "device",         "ms",           "ratio",
                "remap_ms",    "remap_spread",  "psnr_db",        "ws_psnr_db",   "ssim",
                "fsim",        "on_front"}));
  // An image half as wide as the truth is enlarged.
  const auto half = std::ranges::find(all["settings"], "hlf-vd, 32 px wide",
                                      [](const json& setting) { return setting["name"]; });
  ASSERT_NE(half, all["settings"].end());
  EXPECT_GT((*half)["psnr_db"], 10.0);
  EXPECT_LT((*half)["psnr_db"], all["settings"][1]["psnr_db"]);
}

// A parameter without effect would give the same image in the same time under another name.
TEST_F(TradeTest, SettingsVaryEveryParameterThatHasAnEffectAndAreNamedByIt) {
  sweep({ViewMethod::kInitial, ViewMethod::kHlfVd, ViewMethod::kTwoSided});
  const json all = traded();
  std::set<std::string> names, initial, second_sides;
  std::map<std::string, std::set<std::string>> values;
  for (const json& setting : all["settings"]) {
    EXPECT_TRUE(names.insert(setting["name"]).second) << setting["name"];
    if (setting["method"] == "initial") initial.insert(setting["name"]);
    if (setting["method"] == "hlf-vd") second_sides.insert(setting["second_side"].dump());
    for (const json& parameter : all["parameters"]) {
      values[parameter["key"]].insert(setting[parameter["key"].get<std::string>()].dump());
    }
  }
  for (const auto& [parameter, taken] : values) EXPECT_GE(taken.size(), 2U) << parameter;
  EXPECT_THAT(values["stations_mixed"], SizeIs(5));
  EXPECT_THAT(values["k_deg"], SizeIs(4));  // the central one too
  EXPECT_THAT(values["overlap_deg"], SizeIs(3));
  EXPECT_THAT(initial, SizeIs(1));
  EXPECT_THAT(second_sides, SizeIs(1)) << "of hlf-vd, which shows one side";
  EXPECT_THAT(names, IsSupersetOf({"hlf-vd", "two-sided", "hlf-vd, cubic", "hlf-vd, k 45°",
                                   "hlf-vd, stations 16", "hlf-vd, 32 px wide",
                                   "two-sided, cubic, stations 8, second side faded"}));
}

// On what stands in for a card, if this machine has none. Views are chosen by the processor's
// times.
TEST_F(TradeTest, SettingsAreMeasuredOnACardToo) {
  sweep({ViewMethod::kHlfVd});
  const std::size_t on_processor = traded()["settings"].size();
  options_.device = Device::kGpu;
  const json all = traded();
  EXPECT_NE(all["machine"]["gpu"], "");
  std::map<std::string, json> settings;
  for (const json& setting : all["settings"]) settings[setting["name"]] = setting;
  EXPECT_EQ(settings.size(), 2 * on_processor - 1) << "one is of a single thread";
  EXPECT_EQ(settings["hlf-vd"]["device"], "cpu");
  EXPECT_EQ(settings["hlf-vd, gpu"]["device"], "gpu");
  EXPECT_NEAR(settings["hlf-vd, gpu"]["psnr_db"].get<double>(),
              settings["hlf-vd"]["psnr_db"].get<double>(), 0.02);
  const auto measured = read_measured_settings(room_.directory());
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->choices.size(), on_processor - 1);
}

// No other setting is at least as fast and as good, and better in one.
TEST_F(TradeTest, TheFrontIsWhatNothingElseDominates) {
  const json settings = traded()["settings"];
  int on_front = 0;
  for (const json& setting : settings) {
    const bool dominated = std::ranges::any_of(settings, [&](const json& other) {
      return other["ratio"] < setting["ratio"] && other["psnr_db"] >= setting["psnr_db"];
    });
    EXPECT_EQ(setting["on_front"], !dominated) << setting["name"];
    on_front += dominated ? 0 : 1;
  }
  EXPECT_GE(on_front, 1);
  EXPECT_LT(on_front, 5);
}

// Times are less certain then, but chosen by all the same.
TEST_F(TradeTest, ABusyMachineIsNamedOnce) {
  EXPECT_EQ(traded()["busy"], false);
  EXPECT_THAT(said_, Not(HasSubstr("busy")));
  busy_ = true;
  EXPECT_EQ(traded()["busy"], true);
  EXPECT_THAT(said_, HasSubstr("other programs were busy"));
  EXPECT_EQ(read_measured_settings(room_.directory())->choices.size(), 5U);
}

TEST_F(TradeTest, ScoresAreThoseOfTheViews) {
  const json settings = traded()["settings"];
  std::vector<nlohmann::ordered_json> scores;
  for (const auto& [name, at] :
       {std::pair("near.png", PlanPoint{0.4, 0.0}), std::pair("middle.png", PlanPoint{0.0, 0.0})}) {
    const cv::Mat view = Renderer(room_, options_.presets[2].options).render(at).image;
    TrueView truth;
    truth.image = read_panorama(directory_ / name);
    scores.push_back(scores_of(view, truth, features_of(view, truth)));
  }
  for (const char* key : {"psnr_db", "ws_psnr_db", "ssim", "fsim"}) {
    EXPECT_NEAR(settings[2][key].get<double>(), mean_of(scores, key).get<double>(), 1e-9) << key;
  }
  EXPECT_GT(settings[1]["psnr_db"], settings[0]["psnr_db"]) << "corrected is better than initial";
}

TEST_F(TradeTest, TheTableHoldsTheNumbersOfTheJson) {
  const json settings = traded()["settings"];
  const auto records = split_csv(read_file(report_ / "trade.csv"), "trade.csv");
  ASSERT_EQ(records.size(), settings.size() + 1);
  const std::vector<std::string>& header = records[0].fields;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const std::vector<std::string>& row = records[i + 1].fields;
    ASSERT_EQ(row.size(), settings[i].size());
    for (std::size_t column = 0; column < header.size(); ++column) {
      const json& value = settings[i][header[column]];
      if (value.is_boolean()) {
        EXPECT_EQ(row[column], value.get<bool>() ? "1" : "0") << header[column];
      } else if (value.is_string()) {
        EXPECT_EQ(row[column], value) << header[column];
      } else {
        EXPECT_EQ(std::stod(row[column]), value.get<double>()) << header[column];
      }
    }
  }
}

TEST_F(TradeTest, ARoomWithoutDistancesIsSweptInitialWithANote) {
  make_room({.overhang_m = 0.25, .width = 64, .distances = false});
  sweep({ViewMethod::kInitial});
  const json all = traded();
  EXPECT_THAT(said_, HasSubstr("no distances"));
  EXPECT_EQ(all["distances"], "none");
  // It is stored in the room, for choosing views.
  EXPECT_EQ(all["distances_sha256"], distances_sha256(room_));
  EXPECT_FALSE(all["settings"].empty());
  for (const json& setting : all["settings"]) EXPECT_EQ(setting["method"], "initial");
}

TEST_F(TradeTest, RefusesBadInputBeforeAnyWork) {
  list("gone.png,0,0,0\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("gone.png")));
  make_truth("wide", {0.0, 0.1}, 128);
  list("near.png,0.4,0,0\nwide.png,0,0,0.1\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("wide.png is 128"), HasSubstr("one width")));
  list("near.png,0.4,0,0\n");
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
  options_.held_out = 4;
  EXPECT_THAT(run_error(), HasSubstr("one of both"));
  options_.truth.clear();
  options_.held_out = 0;
  EXPECT_THAT(run_error(), HasSubstr("with --truth, or use stations"));
}

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
  const json whole = traded();
  // Behind the second setting; what was measured before is not measured again.
  const auto interrupted = [&] {
    works_ = 0;
    interrupted_at_ = 2 * kWorksOfASetting;
    EXPECT_THROW(trade(room_, options_), Interrupted);
    std::set<double> times_ms;
    for (const json& kept : kept_in(report_ / "trade.partial")) {
      times_ms.insert(kept["ms"].get<double>());
    }
    interrupted_at_ = -1;
    return times_ms;
  };
  const std::set<double> kept_ms = interrupted();
  ASSERT_EQ(kept_ms.size(), 2U);
  const json resumed = traded();
  EXPECT_EQ(timeless(resumed), timeless(whole));
  for (int i : {0, 1}) EXPECT_TRUE(kept_ms.contains(resumed["settings"][i]["ms"].get<double>()));
  EXPECT_FALSE(files().contains("trade.partial"));
  interrupted();
  write_image(directory_ / "near.png", ~read_panorama(directory_ / "near.png"));
  EXPECT_LT(traded()["settings"][0]["psnr_db"], whole["settings"][0]["psnr_db"])
      << "other truths are never mixed in";
}

TEST_F(TradeTest, StationsReplaceTrueViews) {
  make_room({.spacing_m = 0.0625, .overhang_m = 0.25, .width = 64});
  sweep({ViewMethod::kInitial, ViewMethod::kHlfVd});
  options_.presets = {{"plain", "it is central", {.k_deg = 80.0}},
                      {"own", "it is not", {.k_deg = 55.0, .stations_mixed = 7}}};
  options_.truth.clear();
  options_.held_out = 4;
  const json all = traded();
  EXPECT_THAT(said_, HasSubstr("preset own"));
  EXPECT_EQ(all["truth"], "one of 4 stations, held out");
  EXPECT_FALSE(all["views"].empty());
  const json& settings = all["settings"];
  EXPECT_GT(settings[1]["psnr_db"], settings[0]["psnr_db"]) << "corrected views are better";
  ASSERT_EQ(all["presets"].size(), 2U);
  const auto named = [&](int preset) {
    return settings[all["presets"][preset]["number"].get<std::size_t>() - 1]["name"];
  };
  EXPECT_EQ(named(0), "hlf-vd");
  EXPECT_EQ(named(1), "preset own");
  EXPECT_EQ(all["presets"][1]["reason"], "it is not");
  // The room keeps all but the settings on one thread.
  const auto stored = read_measured_settings(room_.directory());
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->distances_sha256, distances_sha256(room_));
  EXPECT_EQ(stored->width_px, 64);
  const auto own = std::ranges::count(settings, all["machine"]["threads"],
                                      [](const json& setting) { return setting["threads"]; });
  EXPECT_EQ(std::ssize(stored->choices), own);
  const MeasuredChoice& last = stored->choices.back();
  EXPECT_EQ(last.name, "preset own");
  EXPECT_EQ(last.options.stations_mixed, 7);
  EXPECT_EQ(last.psnr_db, settings.back()["psnr_db"]);
  EXPECT_EQ(last.ratio, settings.back()["ratio"]);
}

}  // namespace
}  // namespace raywalk
