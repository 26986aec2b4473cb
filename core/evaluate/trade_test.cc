#include "core/evaluate/trade.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/evaluate/measured_settings.h"
#include "core/evaluate/scores.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/room/requirements.h"
#include "core/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;
using nlohmann::json;

// Of two views timed once: each to warm up and to be timed, the remap beside each and once before.
constexpr int kWorksOfASetting = 7;

// Time that passes as a test says: every work takes the next millisecond more, so that all times
// differ and are steady; or, if busy, sometimes three times as long.
class TestClock {
 public:
  TimeSource source() {
    return [this](const std::function<void()>& work) {
      work();
      taken_s_ += 1e-6;
      return busy && ++works_ % 3 != 0 ? 3.0 * taken_s_ : taken_s_;
    };
  }
  bool busy = false;

 private:
  double taken_s_ = 1.0;
  int works_ = 0;
};

class TradeTest : public ::testing::Test {
 protected:
  TradeTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    write_image(directory_ / "near.png", render_truth(spec_, {0.4, 0.0}, 64));
    write_image(directory_ / "middle.png", render_truth(spec_, {0.0, 0.1}, 64));
    list("near.png,0.4,0,0\nmiddle.png,0,0,0.1\n");
    options_.truth = directory_ / "gt.csv";
    options_.report = directory_ / "report";
    options_.repetitions = 1;
    options_.centres = {options_of(Generation::kInitial), options_of(Generation::kHlfVd)};
  }
  void make_room(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }
  static ViewOptions options_of(Generation generation) {
    return {.generation = generation, .k_deg = 80.0};
  }
  void list(const std::string& rows) const {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z\n" << rows;
  }
  // A few settings only, for speed.
  TradeInput input(const std::vector<ViewOptions>& parameters) const {
    TradeInput input{.room = &room_,
                     .rendered_from = &room_,
                     .truth = options_.truth.string(),
                     .repetitions = 1,
                     .time_source = clock_.source()};
    for (const ListedTruth& truth : read_truth(options_.truth, room_)) {
      input.views.push_back(read_view(truth));
    }
    for (const ViewOptions& options : parameters) {
      TradeSetting setting{"setting " + std::to_string(input.settings.size()), options,
                           thread_count()};
      if (setting.options.width == 0) setting.options.width = 64;
      input.settings.push_back(setting);
    }
    return input;
  }
  TradeInput few() const {
    return input({{.generation = Generation::kInitial, .k_deg = 90.0},
                  {.k_deg = 90.0},
                  {.k_deg = 45.0, .stations_mixed = 4},
                  {.k_deg = 90.0, .width = 32},
                  {.generation = Generation::kTwoSided, .k_deg = 90.0}});
  }
  std::filesystem::path partial() const { return options_.report / "trade.partial"; }
  // A run that is interrupted behind the second setting.
  void begin(TradeInput input) const {
    input.time_source = [&, works = 0](const std::function<void()>& work) mutable {
      if (works++ == 2 * kWorksOfASetting) throw Interrupted("now");
      return clock_.source()(work);
    };
    EXPECT_THROW(write_trade(input, options_.report), Interrupted);
  }
  nlohmann::json written() const {
    return nlohmann::json::parse(read_file(options_.report / "trade.json"));
  }
  std::string run_error() const {
    try {
      trade(room_, options_);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  mutable TestClock clock_;
  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
  TradeOptions options_;
};

std::set<std::string> keys_of_setting(const json& object) {
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
  EXPECT_EQ(all["format_version"], 6);
  EXPECT_EQ(all["room"], room_.directory().string());
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["views"].size(), 2U);
  EXPECT_EQ(all["width_px"], 64);
  EXPECT_GE(all["machine"]["threads"], 1);
  EXPECT_GT(all["remap_ms"], 0.0);
  EXPECT_GT(all["settings"].size(), 15U);
  EXPECT_EQ(all["settings"][1]["number"], 2);
  EXPECT_EQ(all["parameters"][0]["key"], "generation");
  EXPECT_EQ(all["parameters"][0]["default"], "hlf-vd");
  EXPECT_EQ(
      keys_of_setting(all["settings"][0]),
      (std::set<std::string>{"number",       "name",          "generation",    "k_deg",
                             "overlap_deg",  "width_px",      "interpolation", "stations_mixed",
                             "station_fade", "distance_maps", "second_side",   "threads",
                             "ms",           "ratio",         "remap_ms",      "remap_spread",
                             "psnr_db",      "ws_psnr_db",    "ssim",          "fsim",
                             "on_front"}));
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
  EXPECT_EQ(read_measured_settings(room_.directory())->choices.size(), 5U);
}

TEST_F(TradeTest, ScoresAreThoseOfTheViews) {
  write_trade(few(), options_.report);
  const json settings = written()["settings"];
  std::vector<nlohmann::ordered_json> scores;
  for (const auto& [name, at] :
       {std::pair("near.png", PlanPoint{0.4, 0.0}), std::pair("middle.png", PlanPoint{0.0, 0.1})}) {
    const cv::Mat view = Renderer(room_, {.k_deg = 45.0, .stations_mixed = 4}).render(at).image;
    scores.push_back(scores_of(view, read_panorama(directory_ / name)));
  }
  for (const char* key : {"psnr_db", "ws_psnr_db", "ssim", "fsim"}) {
    EXPECT_NEAR(settings[2][key].get<double>(), mean_of(scores, key).get<double>(), 1e-9) << key;
  }
  // Corrected is better than initial, as wide as the truth better than half.
  EXPECT_GT(settings[1]["psnr_db"], settings[0]["psnr_db"]);
  EXPECT_GT(settings[1]["psnr_db"], settings[3]["psnr_db"]);
  EXPECT_GT(settings[3]["psnr_db"], 10.0);
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
      if (value.is_boolean()) {
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

TEST_F(TradeTest, ARoomWithoutDistancesIsSweptInitialWithANote) {
  make_room({.overhang_m = 0.25, .width = 64, .distances = false});
  options_.centres = {options_of(Generation::kInitial)};
  EXPECT_THAT(trade(room_, options_), HasSubstr("no distances"));
  EXPECT_EQ(written()["distances"], "none");
  // It is stored in the room, for choosing views.
  EXPECT_EQ(written()["distances_sha256"], distances_sha256(room_));
  const json all = written();
  EXPECT_FALSE(all["settings"].empty());
  for (const json& setting : all["settings"]) EXPECT_EQ(setting["generation"], "initial");
}

TEST_F(TradeTest, RefusesBadInputBeforeAnyWork) {
  list("gone.png,0,0,0\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("gone.png")));
  list("near.png,9,0,0\n");
  EXPECT_THAT(run_error(), HasSubstr("gt.csv:2"));
  write_image(directory_ / "wide.png", render_truth(spec_, {0.0, 0.1}, 128));
  list("near.png,0.4,0,0\nwide.png,0,0,0.1\n");
  EXPECT_THAT(run_error(), AllOf(HasSubstr("wide.png is 128"), HasSubstr("one width")));
  list("near.png,0.4,0,0\n");
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
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
  write_trade(few(), options_.report);
  const json whole = written();
  begin(few());
  std::string text = read_file(partial());
  text.erase(0, text.find('\n'));
  std::set<double> kept_ms;
  for (const json& setting : json::parse(text)) kept_ms.insert(setting["ms"].get<double>());
  ASSERT_EQ(kept_ms.size(), 2U);
  write_trade(few(), options_.report);
  EXPECT_EQ(timeless(written()), timeless(whole));
  // Settings measured before the interruption were not measured again.
  for (int i : {0, 1}) EXPECT_TRUE(kept_ms.contains(written()["settings"][i]["ms"].get<double>()));
  EXPECT_FALSE(fs::exists(partial()));
  begin(few());
  TradeInput other = few();
  other.views[0].image = ~other.views[0].image;
  write_trade(other, options_.report);
  EXPECT_LT(written()["settings"][0]["psnr_db"], whole["settings"][0]["psnr_db"])
      << "other truths are never mixed in";
}

class HeldOutTradeTest : public TradeTest {
 protected:
  HeldOutTradeTest() {
    make_room({.spacing_m = 0.0625, .overhang_m = 0.25, .width = 64});
    options_.held_out = 4;
    options_.presets = {{"plain", "it is central", options_of(Generation::kHlfVd)},
                        {"own", "it is not", {.k_deg = 55.0, .stations_mixed = 7}}};
  }
};

TEST_F(HeldOutTradeTest, StationsReplaceTrueViews) {
  options_.truth.clear();
  const std::string said = trade(room_, options_);
  EXPECT_THAT(said, HasSubstr("preset own"));
  const json all = written();
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

TEST_F(HeldOutTradeTest, NeedsTruthOrHeldOutStations) {
  EXPECT_THAT(run_error(), HasSubstr("one of both"));
  options_.truth.clear();
  options_.held_out = 0;
  EXPECT_THAT(run_error(), HasSubstr("with --truth, or use stations"));
}

}  // namespace
}  // namespace raywalk
