#include "render/view_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
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

TEST_F(ViewSettingsTest, EveryParameterCanBeSetInTheFileAndByFlag) {
  const ViewSettings by_file = view_settings(
      file_flags("interpolation: cubic\narithmetic: double\nsecond_side: where-hidden\n"
                 "stations_mixed: 1\nstation_stride: 3\ndistance_maps: 2\nfill_stations: 5\n"
                 "skip_px: 0.25\ngains: off\n"));
  ViewSettings expected;
  expected.interpolation = "cubic";
  expected.arithmetic = "double";
  expected.second_side = "where-hidden";
  expected.stations_mixed = 1;
  expected.station_stride = 3;
  expected.distance_maps = 2;
  expected.fill_stations = 5;
  expected.skip_px = 0.25;
  expected.gains = "off";
  EXPECT_TRUE(by_file == expected);
  ViewFlags flags;
  flags.interpolation = "cubic";
  flags.arithmetic = "double";
  flags.second_side = "where-hidden";
  flags.stations_mixed = 1;
  flags.station_stride = 3;
  flags.distance_maps = 2;
  flags.fill_stations = 5;
  flags.skip_px = 0.25;
  flags.no_gains = true;
  EXPECT_TRUE(view_settings(flags) == expected);
  // And they reach the renderer.
  write_synthetic_room({.width = 32}, directory_ / "room.lf");
  const ViewOptions options = view_mode(expected, Room::open(directory_ / "room.lf")).options;
  EXPECT_EQ(options.interpolation, Interpolation::kCubic);
  EXPECT_EQ(options.arithmetic, Arithmetic::kDouble);
  EXPECT_EQ(options.second_side, SecondSide::kWhereHidden);
  EXPECT_EQ(options.stations_mixed, 1);
  EXPECT_EQ(options.station_stride, 3);
  EXPECT_EQ(options.distance_maps, 2);
  EXPECT_EQ(options.fill_stations, 5);
  EXPECT_EQ(options.skip_px, 0.25);
  EXPECT_FALSE(options.gains);
}

TEST_F(ViewSettingsTest, ParametersOutOfRangeAreRejected) {
  for (const char* line : {"stations_mixed: 3", "station_stride: 0", "distance_maps: 5",
                           "fill_stations: -1", "skip_px: 4.1", "skip_px: .nan",
                           "interpolation: best", "second_side: always", "preset: quick"}) {
    EXPECT_THAT(message_of(file_flags(std::string("k_deg: auto\n") + line)),
                HasSubstr("view.yaml:2"))
        << line;
  }
}

TEST_F(ViewSettingsTest, FlagsOverrideTheFile) {
  ViewFlags flags = file_flags("generation: two-sided\nk_deg: 70\nlayers: 8\noverlap_deg: 2\n");
  flags.k_deg = "80";
  flags.overlap_deg = 3.0;
  const ViewSettings settings = view_settings(flags);
  EXPECT_EQ(settings.generation, "two-sided");
  EXPECT_EQ(settings.k_deg, "80");
  EXPECT_EQ(settings.layers, "8");
  EXPECT_EQ(settings.overlap_deg, 3.0);
}

TEST_F(ViewSettingsTest, AConnectionOnTheCommandLineDoesNotInheritTheFilesK) {
  ViewFlags flags = file_flags("connection: hybrid\nk_deg: 70\n");
  flags.connection = "lfu";
  EXPECT_EQ(view_settings(flags).k_deg, "auto");
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
  EXPECT_THAT(message_of({.connection = "lfu", .k_deg = "76"}), HasSubstr("k = 45"));
  EXPECT_THAT(message_of({.connection = "rayspace360", .k_deg = "45"}), HasSubstr("k = 90"));
  EXPECT_EQ(message_of({.connection = "lfu", .k_deg = "45"}), "no error");
  EXPECT_EQ(message_of({.connection = "rayspace360", .k_deg = "90.0"}), "no error");
  EXPECT_THAT(message_of({.k_deg = "44.9"}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.k_deg = "nan"}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.k_deg = "80x"}), HasSubstr("45..90"));
  EXPECT_THAT(message_of({.layers = "0"}), HasSubstr("1..65536"));
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
  EXPECT_EQ(view_mode({.connection = "hybrid", .k_deg = "76"}, room).options.k_deg, 76.0);
  const ViewMode automatic = view_mode({}, room);
  EXPECT_EQ(automatic.options.k_deg, 90.0);
  EXPECT_THAT(automatic.k_source, HasSubstr("not measured on this room"));
}

TEST(ViewSettingsRanges, NotANumberIsInNoRange) {
  const double nan = std::nan("");
  for (const ViewFlags& flags :
       {ViewFlags{.tolerance_px = nan}, ViewFlags{.overlap_deg = nan}, ViewFlags{.skip_px = nan}}) {
    EXPECT_THROW(view_settings(flags), UsageError);
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
    write_file_atomically(requirements_path(room.directory()), requirements_to_json(required));
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
  EXPECT_EQ(view_mode({.k_deg = "70"}, room).options.k_deg, 70.0);
  EXPECT_EQ(view_mode({.layers = "8"}, room).options.layers, 8);
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
  EXPECT_EQ(view_mode({.k_deg = "70", .layers = "8"}, room).options.k_deg, 70.0);
}

}  // namespace
}  // namespace raywalk::render
