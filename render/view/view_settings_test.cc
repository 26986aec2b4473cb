#include "render/view/view_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string message_of(const ViewFlags& flags) {
  try {
    view_settings(flags);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "no error";
}

class ViewSettingsTest : public ::testing::Test {
 protected:
  ViewFlags file_flags(const std::string& yaml) const {
    std::ofstream(directory_ / "view.yaml") << yaml;
    return {.settings = directory_ / "view.yaml"};
  }

  TestDirectory directory_;
};

TEST_F(ViewSettingsTest, TheShippedFileHoldsTheDefaults) {
  EXPECT_TRUE(view_settings({.settings = RAYWALK_CONFIGS "/view.yaml"}) == ViewSettings());
}

TEST_F(ViewSettingsTest, TheShippedFileExplainsEveryParameter) {
  std::set<std::string> keys{"preset", "connection"};
  for (const ViewParameter& parameter : kViewParameters) keys.insert(parameter.key);
  EXPECT_EQ(keys_of_yaml(RAYWALK_CONFIGS "/view.yaml"), keys);
}

// A value of a parameter that is not its default.
double other_value(const ViewParameter& parameter) {
  if (parameter.value.kind == ParameterKind::kChoice)
    return default_of(parameter) == 0.0 ? 1.0 : 0.0;
  return default_of(parameter) == parameter.least ? parameter.most : parameter.least;
}

TEST_F(ViewSettingsTest, EveryParameterCanBeSetInTheFileAndByFlag) {
  for (const ViewParameter& parameter : kViewParameters) {
    const std::string text = text_of(parameter, other_value(parameter));
    ViewSettings expected;
    parameter.value.set(&expected.options, other_value(parameter));
    ASSERT_FALSE(expected == ViewSettings()) << parameter.key;
    EXPECT_TRUE(view_settings(file_flags(parameter.key + (": " + text))) == expected)
        << parameter.key;
    EXPECT_TRUE(view_settings({.parameters = {{parameter.key, text}}}) == expected)
        << parameter.key;
    // And it reaches the renderer.
    EXPECT_EQ(parameter.value.get(view_mode(expected).options), other_value(parameter))
        << parameter.key;
  }
}

TEST_F(ViewSettingsTest, ParametersOutOfRangeAreRejected) {
  for (const char* line :
       {"stations_mixed: 17", "stations_mixed: 1.5", "distance_maps: 9", "distance_maps: '2'",
        "overlap_deg: 45.1", "overlap_deg: .nan", "width_px: 30", "k_deg: 0", "interpolation: best",
        "second_side: always", "preset: quick"}) {
    EXPECT_THAT(message_of(file_flags(std::string("k_deg: 80\n") + line)), HasSubstr("view.yaml:2"))
        << line;
  }
}

TEST_F(ViewSettingsTest, FlagsOverrideTheFile) {
  ViewFlags flags = file_flags("method: two-sided\nk_deg: 70\ndistance_maps: 3\noverlap_deg: 2\n");
  flags.parameters = {{"k_deg", "80"}, {"overlap_deg", "3"}};
  const ViewSettings settings = view_settings(flags);
  EXPECT_EQ(settings.options.method, ViewMethod::kTwoSided);
  EXPECT_EQ(settings.options.k_deg, 80.0);
  EXPECT_EQ(settings.options.distance_maps, 3);
  EXPECT_EQ(settings.options.overlap_deg, 3.0);
}

TEST_F(ViewSettingsTest, AConnectionOnTheCommandLineDoesNotInheritTheFilesK) {
  ViewFlags flags = file_flags("connection: hybrid\nk_deg: 70\n");
  flags.connection = "lfu";
  EXPECT_EQ(view_settings(flags).options.k_deg, 90.0);
}

TEST_F(ViewSettingsTest, MistakesInTheFileNameTheFile) {
  EXPECT_THAT(message_of(file_flags("overlap_dge: 5\n")),
              AllOf(HasSubstr("view.yaml:1"), HasSubstr("did you mean 'overlap_deg'")));
  EXPECT_THAT(message_of(file_flags("method: perfect\n")), HasSubstr("view.yaml:1"));
  EXPECT_THAT(message_of(file_flags("k_deg: 30\n")),
              AllOf(HasSubstr("view.yaml"), HasSubstr("45..90")));
  EXPECT_THAT(message_of(file_flags("connection: lfu\nk_deg: 60\n")),
              AllOf(HasSubstr("view.yaml"), HasSubstr("k = 45")));
}

TEST_F(ViewSettingsTest, RejectsAKThatContradictsTheConnection) {
  EXPECT_THAT(message_of({.connection = "lfu", .parameters = {{"k_deg", "76"}}}),
              HasSubstr("k = 45"));
  EXPECT_THAT(message_of({.connection = "rayspace360", .parameters = {{"k_deg", "45"}}}),
              HasSubstr("k = 90"));
  EXPECT_EQ(message_of({.connection = "lfu", .parameters = {{"k_deg", "45"}}}), "no error");
  EXPECT_EQ(message_of({.connection = "rayspace360", .parameters = {{"k_deg", "90.0"}}}),
            "no error");
  EXPECT_THAT(message_of({.parameters = {{"k_deg", "44.9"}}}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.parameters = {{"k_deg", "nan"}}}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.parameters = {{"k_deg", "80x"}}}), HasSubstr("45..90"));
}

class ViewModeTest : public ViewSettingsTest {
 protected:
  Room room_of(bool distances) const {
    write_synthetic_room({.width = 32, .distances = distances}, path_);
    return Room::open(path_);
  }

  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(ViewModeTest, TheThreeConnectionsAreOneRuleWithTheirOwnK) {
  EXPECT_EQ(view_mode({.connection = "lfu"}).options.k_deg, 45.0);
  EXPECT_EQ(view_mode({.connection = "rayspace360"}).options.k_deg, 90.0);
  EXPECT_EQ(view_mode(view_settings({.parameters = {{"k_deg", "76"}}})).options.k_deg, 76.0);
  EXPECT_EQ(view_mode({}).options.k_deg, 90.0);
}

TEST_F(ViewModeTest, AllMethodsThatTheRoomSupports) {
  EXPECT_EQ(view_modes({}, {}, room_of(false)).size(), 1U);
  const std::vector<ViewMode> all = view_modes({}, {}, room_of(true));
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].options.method, ViewMethod::kInitial);
  EXPECT_EQ(all[1].options.method, ViewMethod::kHlfVd);
  EXPECT_EQ(all[2].options.method, ViewMethod::kTwoSided);
  const std::vector<ViewMode> named = view_modes({}, {"two-sided"}, room_of(true));
  ASSERT_EQ(named.size(), 1U);
  EXPECT_EQ(named[0].options.method, ViewMethod::kTwoSided);
  EXPECT_THROW(view_modes({}, {"initial", "initial"}, room_of(true)), UsageError);
}

}  // namespace
}  // namespace raywalk::render
