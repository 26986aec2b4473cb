#include "render/view_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"
#include "core/room/requirements.h"
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
  EXPECT_TRUE(view_settings({.settings = RAYWALK_VIEW_YAML}) == ViewSettings());
}

TEST_F(ViewSettingsTest, TheShippedFileExplainsEveryDial) {
  std::set<std::string> keys{"preset", "connection"};
  for (const Dial& dial : kDials) keys.insert(dial.key);
  EXPECT_EQ(keys_of_yaml(RAYWALK_VIEW_YAML), keys);
}

// A value of a dial that is not its default.
double other_value(const Dial& dial) {
  if (dial.value.kind == DialKind::kChoice) return default_of(dial) == 0.0 ? 1.0 : 0.0;
  return default_of(dial) == dial.least ? dial.most : dial.least;
}

TEST_F(ViewSettingsTest, EveryDialCanBeSetInTheFileAndByFlag) {
  write_synthetic_room({.width = 32}, directory_ / "room.lf");
  const Room room = Room::open(directory_ / "room.lf");
  for (const Dial& dial : kDials) {
    const std::string text = text_of(dial, other_value(dial));
    ViewSettings expected;
    dial.value.set(&expected.options, other_value(dial));
    ASSERT_FALSE(expected == ViewSettings()) << dial.key;
    EXPECT_TRUE(view_settings(file_flags(dial.key + (": " + text))) == expected) << dial.key;
    EXPECT_TRUE(view_settings({.dials = {{dial.key, text}}}) == expected) << dial.key;
    // And it reaches the renderer.
    EXPECT_EQ(dial.value.get(view_mode(expected, room).options), other_value(dial)) << dial.key;
  }
}

// What stood in files before it was left to tests and benchmarks.
TEST_F(ViewSettingsTest, WhatIsNoDialIsAnUnknownKey) {
  for (const char* line : {"arithmetic: double", "station_stride: 2", "fill_stations: 8"}) {
    EXPECT_THAT(message_of(file_flags(line)), HasSubstr("view.yaml:1: unknown key"));
  }
}

TEST_F(ViewSettingsTest, ParametersOutOfRangeAreRejected) {
  for (const char* line :
       {"stations_mixed: 3", "stations_mixed: 1.5", "distance_maps: 5", "distance_maps: '2'",
        "skip_px: 4.1", "skip_px: .nan", "width_px: 30", "layers: 0", "k_deg: 0",
        "interpolation: best", "second_side: always", "preset: quick"}) {
    EXPECT_THAT(message_of(file_flags(std::string("k_deg: auto\n") + line)),
                HasSubstr("view.yaml:2"))
        << line;
  }
}

TEST_F(ViewSettingsTest, FlagsOverrideTheFile) {
  ViewFlags flags = file_flags("generation: two-sided\nk_deg: 70\nlayers: 8\noverlap_deg: 2\n");
  flags.dials = {{"k_deg", "80"}, {"overlap_deg", "3"}};
  const ViewSettings settings = view_settings(flags);
  EXPECT_EQ(settings.options.generation, Generation::kTwoSided);
  EXPECT_EQ(settings.options.k_deg, 80.0);
  EXPECT_EQ(settings.options.layers, 8);
  EXPECT_EQ(settings.options.overlap_deg, 3.0);
}

TEST_F(ViewSettingsTest, AConnectionOnTheCommandLineDoesNotInheritTheFilesK) {
  ViewFlags flags = file_flags("connection: hybrid\nk_deg: 70\n");
  flags.connection = "lfu";
  EXPECT_EQ(view_settings(flags).options.k_deg, 0.0) << "auto";
}

TEST_F(ViewSettingsTest, MistakesInTheFileNameTheFile) {
  EXPECT_THAT(message_of(file_flags("overlap_dge: 5\n")),
              AllOf(HasSubstr("view.yaml:1"), HasSubstr("did you mean 'overlap_deg'")));
  EXPECT_THAT(message_of(file_flags("generation: perfect\n")), HasSubstr("view.yaml:1"));
  EXPECT_THAT(message_of(file_flags("k_deg: 30\n")),
              AllOf(HasSubstr("view.yaml"), HasSubstr("45..90")));
  EXPECT_THAT(message_of(file_flags("layers: none\n")),
              AllOf(HasSubstr("view.yaml"), HasSubstr("1..65536")));
  EXPECT_THAT(message_of(file_flags("connection: lfu\nk_deg: 60\n")),
              AllOf(HasSubstr("view.yaml"), HasSubstr("k = 45")));
}

TEST_F(ViewSettingsTest, RejectsAKThatContradictsTheConnection) {
  EXPECT_THAT(message_of({.connection = "lfu", .dials = {{"k_deg", "76"}}}), HasSubstr("k = 45"));
  EXPECT_THAT(message_of({.connection = "rayspace360", .dials = {{"k_deg", "45"}}}),
              HasSubstr("k = 90"));
  EXPECT_EQ(message_of({.connection = "lfu", .dials = {{"k_deg", "45"}}}), "no error");
  EXPECT_EQ(message_of({.connection = "rayspace360", .dials = {{"k_deg", "90.0"}}}), "no error");
  EXPECT_THAT(message_of({.dials = {{"k_deg", "44.9"}}}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.dials = {{"k_deg", "nan"}}}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.dials = {{"k_deg", "80x"}}}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.dials = {{"layers", "0"}}}), HasSubstr("1..65536"));
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
  const Room room = room_of(false);
  EXPECT_EQ(view_mode({.connection = "lfu"}, room).options.k_deg, 45.0);
  EXPECT_EQ(view_mode({.connection = "rayspace360"}, room).options.k_deg, 90.0);
  EXPECT_EQ(view_mode(view_settings({.dials = {{"k_deg", "76"}}}), room).options.k_deg, 76.0);
  const ViewMode automatic = view_mode({}, room);
  EXPECT_EQ(automatic.options.k_deg, 90.0);
  EXPECT_THAT(automatic.k_source, HasSubstr("not measured on this room"));
}

TEST(ViewSettingsRanges, NotANumberIsInNoRange) {
  for (const char* key : {"tolerance_px", "overlap_deg", "skip_px"}) {
    EXPECT_THROW(view_settings({.dials = {{key, "nan"}}}), UsageError) << key;
  }
}

TEST_F(ViewModeTest, AllGenerationsThatTheRoomSupports) {
  EXPECT_EQ(view_modes({}, {}, room_of(false)).size(), 1U);
  const std::vector<ViewMode> all = view_modes({}, {}, room_of(true));
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].options.generation, Generation::kInitial);
  EXPECT_EQ(all[1].options.generation, Generation::kHlfVd);
  EXPECT_EQ(all[2].options.generation, Generation::kTwoSided);
  const std::vector<ViewMode> named = view_modes({}, {"two-sided"}, room_of(true));
  ASSERT_EQ(named.size(), 1U);
  EXPECT_EQ(named[0].options.generation, Generation::kTwoSided);
  EXPECT_THROW(view_modes({}, {"initial", "initial"}, room_of(true)), UsageError);
}

class RequiredModeTest : public ViewModeTest {
 protected:
  // A room with stored requirements: surfaces from 0.5 to 4 m.
  Room room_with_requirements() {
    Room room = room_of(true);
    RoomRequirements required;
    required.distances_sha256 = distances_sha256(room);
    required.layers = {.omega_min_per_m = 0.25, .omega_max_per_m = 2.0, .by_d_p = {}};
    required.connection.model_k_deg = 61.0;
    write_file_atomically(requirements_path(room.directory()),
                          json_text(requirements_document(required)));
    return room;
  }
};

TEST_F(RequiredModeTest, AutoUsesTheRoomsRequirements) {
  const Room room = room_with_requirements();
  const ViewMode mode = view_mode({}, room);
  EXPECT_EQ(mode.options.k_deg, 90.0) << "the k of least E_t there is a model's";
  ASSERT_TRUE(mode.options.scene);
  // The number of layers follows from the stored range and the view's own distance from the line:
  // 0.5 m across the middle of the cell, more towards the corners.
  Renderer renderer(room, mode.options);
  const int layers = renderer.render({0.0, 0.0}).report.layers;
  const double tolerance_rad = 0.5 * kTwoPi / room.panorama().width;
  EXPECT_GE(layers, layers_for_tolerance({0.25, 2.0}, 0.5, tolerance_rad));
  EXPECT_LE(layers, layers_for_tolerance({0.25, 2.0}, 0.5 * std::sqrt(2.0), tolerance_rad));
  ViewOptions own = mode.options;
  own.scene.reset();
  EXPECT_NE(Renderer(room, own).render({0.0, 0.0}).report.layers, layers)
      << "the maps around the view have another range";
}

TEST_F(RequiredModeTest, ExplicitNumbersOverrideRequirements) {
  const Room room = room_with_requirements();
  EXPECT_EQ(view_mode(view_settings({.dials = {{"k_deg", "70"}}}), room).options.k_deg, 70.0);
  EXPECT_EQ(view_mode(view_settings({.dials = {{"layers", "8"}}}), room).options.layers, 8);
}

TEST_F(RequiredModeTest, RequirementsOfOtherDistancesAreIgnored) {
  room_with_requirements();
  const std::string kept = read_file(requirements_path(path_));
  write_synthetic_room({.width = 32, .distance_every = 2}, path_);
  write_file_atomically(requirements_path(path_), kept);
  const ViewMode mode = view_mode({}, Room::open(path_));
  EXPECT_FALSE(mode.options.scene);
}

TEST_F(RequiredModeTest, DamagedRequirementsMatterOnlyWhereTheyAreUsed) {
  const Room room = room_of(true);
  write_file_atomically(requirements_path(path_), "damaged");
  EXPECT_THROW(view_mode({}, room), Error);
  EXPECT_EQ(
      view_mode(view_settings({.dials = {{"k_deg", "70"}, {"layers", "8"}}}), room).options.k_deg,
      70.0);
}

}  // namespace
}  // namespace raywalk::render
