#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/test_directory.h"
#include "core/room/requirements.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

// The four lines of a square of side 1 around the origin, five stations each.
RoomManifest square_manifest() {
  std::vector<StationPose> stations;
  const auto add = [&](const std::string& name, double x, double z) {
    stations.push_back({name + std::to_string(stations.size()) + ".jpg", {x, 0.1, z}, ""});
  };
  for (int i = 0; i < 5; ++i) add("front", -0.5 + 0.25 * i, 0.5);
  for (int i = 0; i < 5; ++i) add("back", -0.5 + 0.25 * i, -0.5);
  for (int i = 0; i < 5; ++i) add("left", -0.5, -0.5 + 0.25 * i);
  for (int i = 0; i < 5; ++i) add("right", 0.5, -0.5 + 0.25 * i);
  return {{64, 32}, find_grid(stations, {}), std::vector<std::string>(4, std::string(64, 'a'))};
}

std::string manifest_error(const std::string& text) {
  return error_of([&] { manifest_from_json(text, "manifest.json"); });
}

// The error after setting the value at a JSON pointer of a good manifest.
std::string error_with(const std::string& pointer, const Json& value) {
  Json json = Json::parse(manifest_to_json(square_manifest()));
  json[Json::json_pointer(pointer)] = value;
  return manifest_error(json.dump());
}

TEST(Manifest, ReadsBackExactlyWhatItWrote) {
  RoomManifest written = square_manifest();
  written.refined = {.source = "../hall.lf",
                     .source_fingerprint = "abc",
                     .source_stations = 244,
                     .hold_out = 5,
                     .sharpening = {0.75, 1.5}};
  const std::string text = manifest_to_json(written);
  const RoomManifest read = manifest_from_json(text, "manifest.json");
  EXPECT_EQ(manifest_to_json(read), text);
  EXPECT_EQ(read.panorama, written.panorama);
  EXPECT_EQ(read.rays_sha256, written.rays_sha256);
  EXPECT_EQ(read.grid.lines[2].id, "z0");
  EXPECT_EQ(read.grid.lines[2].stations[1].file, written.grid.lines[2].stations[1].file);
  EXPECT_EQ(read.grid.lines[2].stations[1].position_m,
            written.grid.lines[2].stations[1].position_m);
  EXPECT_EQ(read.grid.cells[0].line, written.grid.cells[0].line);
  EXPECT_EQ(read.grid.cells[0].x_max_m, written.grid.cells[0].x_max_m);
  EXPECT_EQ(read.refined->source_stations, 244);
  EXPECT_EQ(read.refined->hold_out, 5);
}

TEST(Manifest, ChecksumsAndARefinedRoomsSourceAreOptional) {
  RoomManifest manifest = square_manifest();
  manifest.rays_sha256.clear();
  const RoomManifest read = manifest_from_json(manifest_to_json(manifest), "m");
  EXPECT_TRUE(read.rays_sha256.empty());
  EXPECT_FALSE(read.refined);
  EXPECT_THAT(error_with("/refined", Json::object()), HasSubstr("has no 'source'"));
}

TEST(Manifest, NamesTheDistancesInUseAndWhetherGainsAre) {
  RoomManifest manifest = square_manifest();
  for (const DistanceKind kind : kDistanceKinds) {
    manifest.distances = kind;
    manifest.gains = kind == DistanceKind::kGiven;
    const RoomManifest read = manifest_from_json(manifest_to_json(manifest), "m");
    EXPECT_EQ(read.distances, kind);
    EXPECT_EQ(read.gains, manifest.gains);
  }
  EXPECT_THAT(error_with("/distances", 3), HasSubstr("distances"));
  EXPECT_THAT(error_with("/distances", "swept"), HasSubstr("is not none, given or estimated"));
  EXPECT_THAT(error_with("/gains", 1), HasSubstr("gains"));
}

TEST(Manifest, UnknownKeysAreIgnored) { EXPECT_EQ(error_with("/note", "hand-made"), "no error"); }

TEST(Manifest, OtherFormatVersionsAreRejected) {
  EXPECT_THAT(error_with("/format_version", kRoomFormatVersion - 1),
              HasSubstr("pack the room again"));
  EXPECT_THAT(
      error_with("/format_version", kRoomFormatVersion + 1),
      AllOf(HasSubstr("manifest.json"), HasSubstr("newer than"), HasSubstr("use a newer Raywalk")));
}

TEST(Manifest, EveryMissingKeyIsNamed) {
  const Json good = Json::parse(manifest_to_json(square_manifest()));
  for (const char* pointer :
       {"/format", "/format_version", "/panorama", "/panorama/width", "/lines", "/cells",
        "/distances", "/gains", "/lines/0/id", "/lines/0/axis", "/lines/0/origin_m",
        "/lines/0/direction", "/lines/0/height_m", "/lines/0/stations", "/lines/0/stations/0/file",
        "/lines/0/stations/0/position_m", "/lines/0/stations/0/along_m", "/cells/0/x_min_m",
        "/cells/0/front"}) {
    const Json::json_pointer place(pointer);
    Json json = good;
    json[place.parent_pointer()].erase(place.back());
    EXPECT_THAT(manifest_error(json.dump()), HasSubstr("has no '" + place.back() + "'")) << pointer;
  }
}

TEST(Manifest, InconsistentValuesAreRejected) {
  EXPECT_THAT(error_with("/format", "other"), HasSubstr("is not raywalk-room"));
  EXPECT_THAT(error_with("/panorama/width", 63), HasSubstr("twice the height"));
  EXPECT_THAT(error_with("/panorama/width", 1e9), HasSubstr("is not an integer"));
  EXPECT_THAT(error_with("/panorama/width", 4000000000U), HasSubstr("is not between"));
  EXPECT_THAT(error_with("/panorama/width", -64), HasSubstr("is not between"));
  EXPECT_THAT(error_with("/lines", Json::array()), HasSubstr("is empty"));
  EXPECT_THAT(error_with("/lines", "x"), HasSubstr("is not a list"));
  EXPECT_THAT(error_with("/lines/0/axis", "y"), HasSubstr("neither x nor z"));
  EXPECT_THAT(error_with("/lines/0/id", "../x0"), HasSubstr("followed by a number"));
  EXPECT_THAT(error_with("/lines/0/id", "z7"), HasSubstr("followed by a number"));
  EXPECT_THAT(error_with("/lines/0/id", "x1"), HasSubstr("occurs twice"));
  EXPECT_THAT(error_with("/lines/0/direction", {2.0, 0.0}), HasSubstr("unit vector"));
  EXPECT_THAT(error_with("/lines/0/direction", {0.0, 1.0}), HasSubstr("axis"));
  EXPECT_THAT(error_with("/lines/0/direction", {1.0}), HasSubstr("2 elements"));
  EXPECT_THAT(error_with("/lines/0/origin_m/0", 1e7), HasSubstr("is not between"));
  EXPECT_THAT(error_with("/lines/0/height_m", "high"), HasSubstr("is not a number"));
  EXPECT_THAT(error_with("/lines/0/stations/1/along_m", 0.3), HasSubstr("contradicts"));
  EXPECT_THAT(error_with("/lines/0/stations/1/position_m/0", 0.3), HasSubstr("contradicts"));
  EXPECT_THAT(error_with("/lines/0/stations", Json::array()), HasSubstr("fewer than two"));
  EXPECT_THAT(error_with("/lines/0/rays_sha256", "abc"), HasSubstr("SHA-256"));
  EXPECT_THAT(error_with("/cells/0/x_min_m", 9.0), HasSubstr("has no area"));
  EXPECT_THAT(error_with("/cells/0/x_min_m", -0.7), HasSubstr("bounds"));
  EXPECT_THAT(error_with("/cells/0/front", "x9"), HasSubstr("does not exist"));
  EXPECT_THAT(error_with("/cells/0/front", "z0"), HasSubstr("wrong axis"));
  EXPECT_THAT(error_with("/cells/0/front", "x0"), HasSubstr("bounds"));
}

TEST(Manifest, StationsMustFollowEachOther) {
  Json json = Json::parse(manifest_to_json(square_manifest()));
  std::swap(json["/lines/0/stations/1"_json_pointer], json["/lines/0/stations/2"_json_pointer]);
  EXPECT_THAT(manifest_error(json.dump()), HasSubstr("does not increase"));
}

class RequirementsTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  static nlohmann::json measured_on(const Room& room) {
    return {{"format", kRequirementsFormat},
            {"format_version", kRequirementsVersion},
            {"distances_sha256", distances_sha256(room)},
            {"layers", {{"omega_max_per_m", 2.0}}},
            {"spacing", {{"needed_with_distances_m", 0.09}}},
            {"storage", {{"worth_width_px", nullptr}, {"needed_distance_width_px", 256}}}};
  }
  void keep(const std::string& text) const {
    write_file_atomically(requirements_path(path_), text);
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(RequirementsTest, AreThoseOfTheRoomsDistances) {
  Room room = room_of({.width = 32});
  EXPECT_FALSE(current_requirements(room));
  const std::string measured = measured_on(room).dump();
  keep(measured);
  const auto required = current_requirements(room);
  ASSERT_TRUE(required);
  EXPECT_EQ(required->omega_max_per_m, 2.0);
  EXPECT_EQ(required->spacing_m, 0.09);
  EXPECT_TRUE(std::isinf(required->worth_width_px));
  EXPECT_EQ(required->distance_width_px, 256);

  SyntheticRoomSpec other{.width = 32};
  other.scene.walls.max_m.x() += 0.01;
  room = room_of(other);
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "different distances";
  room = room_of({.width = 32, .distance_every = 2});
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "fewer distances";
}

TEST_F(RequirementsTest, DamageIsReportedWithARemedy) {
  const Room room = room_of({.width = 32});
  const nlohmann::json whole = measured_on(room);
  std::vector<std::string> damaged{"", "null", "[]", "{}", whole.dump().substr(0, 60)};
  const auto with = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json other = whole;
    other[nlohmann::json::json_pointer(pointer)] = value;
    damaged.push_back(other.dump());
  };
  with("/format", "other");
  with("/format_version", "1");
  with("/format_version", 2);
  with("/layers/omega_max_per_m", nullptr);
  with("/layers/omega_max_per_m", -1.0);
  with("/spacing/needed_with_distances_m", "0.09");
  with("/storage/needed_distance_width_px", 2.5);
  with("/storage/needed_distance_width_px", 0);
  for (const std::string& text : damaged) {
    keep(text);
    EXPECT_THAT(
        error_of([&] { current_requirements(room); }),
        AllOf(HasSubstr("room.lf/require.json: "), HasSubstr("run raywalk-build-lf require")))
        << text;
  }
}

}  // namespace
}  // namespace raywalk
