#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/room/room.h"

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
  try {
    manifest_from_json(text, "manifest.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// The error after setting the value at a JSON pointer of a good manifest.
std::string error_with(const std::string& pointer, const Json& value) {
  Json json = Json::parse(manifest_to_json(square_manifest()));
  json[Json::json_pointer(pointer)] = value;
  return manifest_error(json.dump());
}

TEST(Manifest, ReadsBackExactlyWhatItWrote) {
  const RoomManifest written = square_manifest();
  const RoomManifest read = manifest_from_json(manifest_to_json(written), "manifest.json");
  EXPECT_EQ(read.panorama, written.panorama);
  EXPECT_EQ(read.rays_sha256, written.rays_sha256);
  ASSERT_EQ(read.grid.lines.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    const Line &a = read.grid.lines[i], &b = written.grid.lines[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.axis, b.axis);
    EXPECT_EQ(a.origin.x_m, b.origin.x_m);
    EXPECT_EQ(a.direction.z_m, b.direction.z_m);
    EXPECT_EQ(a.height_m, b.height_m);
    ASSERT_EQ(a.stations.size(), b.stations.size());
    for (size_t s = 0; s < a.stations.size(); ++s) {
      EXPECT_EQ(a.stations[s].file, b.stations[s].file);
      EXPECT_EQ(a.stations[s].position_m, b.stations[s].position_m);
      EXPECT_EQ(a.stations[s].along_m, b.stations[s].along_m);
    }
  }
  ASSERT_EQ(read.grid.cells.size(), 1U);
  EXPECT_EQ(read.grid.cells[0].line, written.grid.cells[0].line);
  EXPECT_EQ(read.grid.cells[0].x_max_m, written.grid.cells[0].x_max_m);
}

TEST(Manifest, ChecksumsMayBeUnknown) {
  RoomManifest manifest = square_manifest();
  manifest.rays_sha256.clear();
  EXPECT_TRUE(manifest_from_json(manifest_to_json(manifest), "m").rays_sha256.empty());
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

TEST(Manifest, SaysWhatARefinedRoomWasMadeFrom) {
  RoomManifest manifest = square_manifest();
  EXPECT_FALSE(manifest_from_json(manifest_to_json(manifest), "m").refined);
  manifest.refined = {.source = "../hall.lf",
                      .source_fingerprint = "abc",
                      .source_stations = 244,
                      .hold_out = 5,
                      .sharpening = {0.75, 1.5}};
  const auto read = manifest_from_json(manifest_to_json(manifest), "m").refined;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->source, "../hall.lf");
  EXPECT_EQ(read->source_fingerprint, "abc");
  EXPECT_EQ(read->source_stations, 244);
  EXPECT_EQ(read->hold_out, 5);
  EXPECT_EQ(read->sharpening, (std::array<double, 2>{0.75, 1.5}));
  EXPECT_THAT(error_with("/refined", Json::object()), HasSubstr("has no 'source'"));
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

TEST(Manifest, InvalidTextIsAOneLineError) {
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("null"),
        std::string("1e999"), std::string("\xff\xfe"),
        std::string("{\"format\": \"raywalk\n-room\"}"),
        manifest_to_json(square_manifest()).substr(0, 500)}) {
    const std::string error = manifest_error(text);
    EXPECT_THAT(error, HasSubstr("manifest.json"));
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

TEST(Manifest, DeepNestingIsRefused) {
  EXPECT_THAT(manifest_error(std::string(100000, '[')), HasSubstr("nested too deeply"));
}

}  // namespace
}  // namespace raywalk
