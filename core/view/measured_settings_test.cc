#include "core/view/measured_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

MeasuredSettings some_settings() {
  const ViewOptions options{.k_deg = 76.5,
                            .overlap_deg = 0.1,
                            .layers = 4,
                            .width = 32,
                            .interpolation = Interpolation::kNearest,
                            .stations_mixed = 1,
                            .distance_maps = 3,
                            .skip_px = 0.25};
  return {.distances_sha256 = "abc",
          .width_px = 64,
          .choices = {{.name = "quick, k 76.5°", .options = options, .ratio = 1.5, .psnr_db = 30.0},
                      {.name = "slow", .ratio = 5.0, .psnr_db = 100.0, .disturbed = true}}};
}

class MeasuredSettingsTest : public ::testing::Test {
 protected:
  MeasuredSettingsTest() { fs::create_directory(room_); }
  std::string message() const {
    return error_of([&] { read_measured_settings(room_); });
  }
  void write_older(const std::string& text) const {
    write_file_atomically(room_ / "trade.json", text);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    const auto stored = read_measured_settings(room_);
    if (!stored) return names;
    for (const MeasuredChoice& choice : stored->settings.choices) names.push_back(choice.name);
    return names;
  }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(MeasuredSettingsTest, AreReadAsWritten) {
  EXPECT_FALSE(read_measured_settings(room_));
  MeasuredSettings written = some_settings();
  written.choices[1].options.width = 64;
  write_measured_settings(room_, written);
  const auto stored = read_measured_settings(room_);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->file, measured_settings_path(room_));
  EXPECT_EQ(stored->settings.distances_sha256, "abc");
  EXPECT_EQ(stored->settings.width_px, 64);
  ASSERT_EQ(stored->settings.choices.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const MeasuredChoice& choice = stored->settings.choices[i];
    EXPECT_EQ(choice.name, written.choices[i].name);
    EXPECT_TRUE(choice.options == written.choices[i].options);
    EXPECT_EQ(choice.ratio, written.choices[i].ratio);
    EXPECT_EQ(choice.psnr_db, written.choices[i].psnr_db);
    EXPECT_EQ(choice.disturbed, written.choices[i].disturbed);
  }
}

TEST_F(MeasuredSettingsTest, DamageIsNamedWithItsPlace) {
  MeasuredSettings one = some_settings();
  one.choices.pop_back();
  write_measured_settings(room_, one);
  const std::string whole = read_file(measured_settings_path(room_));
  const auto with = [&](const std::string& key, const std::string& value) {
    std::string text = whole;
    const std::size_t at = text.rfind("\"" + key + "\": ") + key.size() + 4;
    text.replace(at, text.find_first_of(",}\n", at) - at, value);
    write_file_atomically(measured_settings_path(room_), text);
    return message();
  };
  EXPECT_THAT(
      with("width_px", "99999999999"),
      HasSubstr("measured.json: settings[0]: width_px: 99999999999 is not between 4 and 32768; "
                "measure again with raywalk-render trade"));
  EXPECT_THAT(with("width_px", "33"), HasSubstr("width_px: 33 is not a multiple of 4"));
  EXPECT_THAT(with("width_px", "0"), HasSubstr("width_px: 0 is not between 4 and 32768"));
  EXPECT_THAT(with("width_px", "32.5"), HasSubstr("width_px: 32.5 is not an integer"));
  EXPECT_THAT(with("stations_mixed", "0"), HasSubstr("stations_mixed: 0 is not between 1 and 2"));
  EXPECT_THAT(with("stations_mixed", "4294967297"), HasSubstr("4294967297 is not between 1 and 2"));
  EXPECT_THAT(with("distance_maps", "\"3\""), HasSubstr("distance_maps: \"3\" is not an integer"));
  EXPECT_THAT(with("skip_px", "null"), HasSubstr("skip_px: null is not a number"));
  EXPECT_THAT(with("k_deg", "1e300"), HasSubstr("k_deg: 1e+300 is not between 45 and 90"));
  EXPECT_THAT(with("overlap_deg", "-0.1"), HasSubstr("overlap_deg: -0.1 is not between 0 and 45"));
  EXPECT_THAT(with("layers", "0"), HasSubstr("layers: 0 is not between 1 and 65536"));
  EXPECT_THAT(with("layers", "\"many\""), HasSubstr("layers: is neither auto nor a number"));
  EXPECT_THAT(with("interpolation", "\"best\""),
              HasSubstr("interpolation: is none of nearest, linear, cubic"));
  EXPECT_THAT(with("ratio", "-1"), HasSubstr("ratio: -1 is not between"));
  EXPECT_THAT(with("psnr_db", "101"), HasSubstr("psnr_db: 101 is not between 0 and 100"));
  EXPECT_THAT(with("disturbed", "0"), HasSubstr("disturbed: 0 is not a boolean"));
  EXPECT_THAT(with("format_version", "2"), HasSubstr("newer than 1"));
  write_file_atomically(measured_settings_path(room_), whole.substr(0, 200));
  EXPECT_THAT(message(), HasSubstr("damaged ("));
}

// A trade.json of an earlier version, of one setting.
nlohmann::json older_trade() {
  return nlohmann::json::parse(R"({"format_version": 2, "distances_sha256": "abc", "width_px": 32,
    "machine": {"threads": 2}, "rooms": [{"stored_width_px": 32, "depth": "given, 32 px"}],
    "settings": [{"name": "quick", "generation": "hlf-vd", "k_deg": 76.5, "overlap_deg": 5,
      "layers": "auto", "width_px": 32, "interpolation": "nearest", "arithmetic": "float",
      "stations_mixed": 1, "station_stride": 1, "distance_maps": 3, "fill_stations": 32,
      "second_side": "blend", "skip_px": 0.25, "threads": 2, "stored_width_px": 32,
      "depth": "given, 32 px", "ratio": 1.5, "psnr_db": 30, "disturbed": false}]})");
}

TEST_F(MeasuredSettingsTest, AnEarlierVersionsFileIsRead) {
  write_older(older_trade().dump());
  const auto stored = read_measured_settings(room_);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->file, room_ / "trade.json");
  EXPECT_EQ(stored->settings.distances_sha256, "abc");
  const MeasuredChoice& choice = stored->settings.choices.at(0);
  const ViewOptions expected{.k_deg = 76.5,
                             .width = 32,
                             .interpolation = Interpolation::kNearest,
                             .stations_mixed = 1,
                             .distance_maps = 3,
                             .skip_px = 0.25};
  EXPECT_TRUE(choice.options == expected);
  EXPECT_EQ(choice.ratio, 1.5);
  EXPECT_EQ(choice.psnr_db, 30.0);
}

TEST_F(MeasuredSettingsTest, AnEarlierVersionsSettingsThatNoFlagAsksForAreLeftOut) {
  nlohmann::json trade = older_trade();
  const auto add = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json setting = trade["settings"][0];
    setting["name"] = key;
    setting[key] = value;
    trade["settings"].push_back(setting);
  };
  add("arithmetic", "double");
  add("station_stride", 2);
  add("fill_stations", 8);
  add("threads", 1);
  add("stored_width_px", 64);
  add("depth", "other");
  add("skip_px", 0.5);
  write_older(trade.dump());
  EXPECT_THAT(names(), ElementsAre("quick", "skip_px"));
  trade["settings"][0]["threads"] = 1;
  trade["settings"].erase(7);
  write_older(trade.dump());
  EXPECT_THAT(message(), HasSubstr("no setting of its own room"));
  write_older("{\"format_version\": 3}");
  EXPECT_THAT(message(), HasSubstr("newer than 2"));
}

TEST_F(MeasuredSettingsTest, ANewTradeReplacesAnEarlierVersions) {
  write_older(older_trade().dump());
  write_measured_settings(room_,
                          {.width_px = 32, .choices = {{.name = "new", .options = {.width = 32}}}});
  EXPECT_THAT(names(), ElementsAre("new"));
  EXPECT_FALSE(fs::exists(room_ / "trade.json"));
}

}  // namespace
}  // namespace raywalk
