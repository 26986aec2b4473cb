#include "core/evaluate/measured_settings.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/evaluate/kept_results.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
using nlohmann::ordered_json;

MeasuredChoice some_choice() {
  return {.name = "quick, k 76.5°",
          .options = {.method = ViewMethod::kTwoSided,
                      .k_deg = 76.5,
                      .overlap_deg = 0.1,
                      .width = 32,
                      .interpolation = Interpolation::kCubic,
                      .stations_mixed = 8,
                      .distance_maps = 3,
                      .second_side = SecondSide::kFaded},
          .ratio = 1.5,
          .psnr_db = 30.0};
}

class MeasuredSettingsTest : public ::testing::Test {
 protected:
  MeasuredSettingsTest() { fs::create_directory(room_); }
  std::string message() const {
    return error_of([&] { read_measured_settings(room_); });
  }
  void write(const std::vector<MeasuredChoice>& choices) const {
    write_measured_settings(room_, {.distances_sha256 = "abc", .width_px = 64, .choices = choices});
  }
  std::string text() const { return read_file(measured_settings_path(room_)); }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST(ViewParameterJson, HoldsTheSweptParametersUnderTheirKeys) {
  EXPECT_EQ(swept_parameters_json(some_choice().options).dump(),
            R"({"method":"two-sided","k_deg":76.5,"overlap_deg":0.1,"width_px":32,)"
            R"("interpolation":"cubic","stations_mixed":8,"station_fade":1.0,"distance_maps":3,)"
            R"("second_side":"faded"})");
}

TEST_F(MeasuredSettingsTest, AreReadAsWritten) {
  EXPECT_FALSE(read_measured_settings(room_));
  write({some_choice(), {.name = "slow", .options = {.width = 64}, .psnr_db = 100.0}});
  const auto stored = read_measured_settings(room_);
  ASSERT_TRUE(stored);
  ASSERT_EQ(stored->choices.size(), 2U);
  EXPECT_TRUE(stored->choices[0].options == some_choice().options);
  EXPECT_EQ(stored->choices[0].ratio, 1.5);
  const std::string written = text();
  write_measured_settings(room_, *stored);
  EXPECT_EQ(text(), written);
}

TEST_F(MeasuredSettingsTest, DamageIsNamedWithItsPlace) {
  write({some_choice()});
  const std::string whole = text();
  const auto with = [&](const std::string& key, const std::string& value) {
    std::string changed = whole;
    const std::size_t at = changed.rfind("\"" + key + "\": ") + key.size() + 4;
    changed.replace(at, changed.find_first_of(",}\n", at) - at, value);
    write_file_atomically(measured_settings_path(room_), changed);
    return message();
  };
  EXPECT_THAT(
      with("width_px", "99999999999"),
      HasSubstr("measured.json: settings[0]: width_px: '99999999999' must be 0 or a multiple of 4 "
                "in 4..32768 pixels; measure again with raywalk-render trade"));
  EXPECT_THAT(with("width_px", "33"), HasSubstr("width_px: '33' must be"));
  EXPECT_THAT(with("width_px", "0"), HasSubstr("width_px: '0' must be"));
  EXPECT_THAT(with("stations_mixed", "0"), HasSubstr("stations_mixed: '0' must be"));
  EXPECT_THAT(with("distance_maps", "\"3\""), HasSubstr("distance_maps: \"3\" is not a number"));
  EXPECT_THAT(with("k_deg", "1e300"), HasSubstr("k_deg: '1e+300' must be"));
  EXPECT_THAT(with("interpolation", "\"best\""),
              HasSubstr("interpolation: 'best' is not a valid choice"));
  EXPECT_THAT(with("ratio", "-1"), HasSubstr("ratio: -1 is not between"));
  EXPECT_THAT(with("psnr_db", "101"), HasSubstr("psnr_db: 101 is not between 0 and 100"));
  EXPECT_THAT(with("format_version", "4"), HasSubstr("newer than 3"));
  write_file_atomically(measured_settings_path(room_), whole.substr(0, 200));
  EXPECT_THAT(message(), HasSubstr("damaged ("));
}

class KeptResultsTest : public ::testing::Test {
 protected:
  // What a run finds under a key, or makes.
  ordered_json got(const std::string& key, const ordered_json& made) const {
    return KeptResults(file_).get(key, [&] { return made; });
  }

  TestDirectory directory_;
  std::filesystem::path file_ = directory_ / "some.partial";
};

TEST_F(KeptResultsTest, DamageCountsAsMissing) {
  got("a", {{"x", 12}});
  const std::string whole = read_file(file_);
  std::string changed = whole;
  changed[changed.find("12")] = '7';
  for (const std::string& text :
       {std::string(), std::string("{}"), whole.substr(0, 70), changed, std::string(100, '[')}) {
    write_file_atomically(file_, text);
    EXPECT_EQ(got("a", 1), 1) << text;
    EXPECT_EQ(got("a", 2), 1) << text;
  }
}

TEST_F(KeptResultsTest, AFileThatCannotBeWrittenIsRefusedAtOnce) {
  std::filesystem::create_directory(file_);
  EXPECT_THROW(KeptResults{file_}, Error);
}

}  // namespace
}  // namespace raywalk
