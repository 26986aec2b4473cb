#include "core/room/requirements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// All values differ, so that swapped members are detected.
RoomRequirements example() {
  return {.distances_sha256 = "0123",
          .tolerance_px = 0.25,
          .distance = {.near_m = 0.5,
                       .median_m = 2.5,
                       .far_m = kInfinity,
                       .sky_share = 0.125,
                       .known_share = 0.875,
                       .omega_error_per_m = 0.003},
          .layers = {.omega_min_per_m = 0.0,
                     .omega_max_per_m = 2.0,
                     .by_d_p = {{.d_p_m = 0.75, .layers = 5}, {.d_p_m = 1.25, .layers = 25}}},
          .spacing = {.captured_median_m = 0.0625,
                      .captured_max_m = 0.03125,
                      .needed_without_depth_m = 0.01,
                      .needed_with_layers = {{.layers = 1, .needed_m = 0.02},
                                             {.layers = 4, .needed_m = kInfinity}},
                      .needed_by_error_m = 0.06,
                      .measured_up_to_m = 0.07,
                      .needed_with_distances_m = 0.09,
                      .stations = 244,
                      .stations_needed_without_depth = 243,
                      .stations_needed_with_distances = 32,
                      .held_out = {{.stride = 3,
                                    .step_m = 0.05,
                                    .views = 24,
                                    .psnr_with_distances_db = 38.5,
                                    .psnr_without_depth_db = 21.5,
                                    .psnr_of_tolerance_db = 35.5,
                                    .hidden_share = 0.001}}},
          .connection = {.model_k_deg = 72.0,
                         .measured = {{.generation = "hlf-vd", .k_deg = 86.0, .e_connect = 4.5}}},
          .storage = {.reach_m = 0.55,
                      .panorama_width_px = 1024,
                      .worth_width_px = 2000.5,
                      .distance_width_px = 512,
                      .needed_distance_width_px = 256,
                      .share_within_tolerance = 0.998,
                      .omega_steps = 200,
                      .omega_bits = 8,
                      .ray_bytes = std::uint64_t{1} << 40,
                      .ray_bytes_thinned = 1001,
                      .ray_bytes_worth = 1002,
                      .distance_bytes = 1003,
                      .distance_bytes_needed = 1004},
          .thinned = ThinnedFacts{.room = "a \"room\"",
                                  .stations = 12,
                                  .distance_maps = 7,
                                  .bytes = 1000,
                                  .views = 49,
                                  .psnr_db = 37.5,
                                  .worst_psnr_db = 30.5}};
}

// The content of require.json.
constexpr const char* kExampleJson = R"({
  "format": "raywalk-require", "format_version": 1,
  "distances_sha256": "0123", "tolerance_px": 0.25,
  "distance": {
    "near_m": 0.5, "median_m": 2.5, "far_m": null, "sky_share": 0.125, "known_share": 0.875,
    "omega_error_per_m": 0.003},
  "layers": {
    "omega_min_per_m": 0.0, "omega_max_per_m": 2.0,
    "by_d_p": [{"d_p_m": 0.75, "layers": 5}, {"d_p_m": 1.25, "layers": 25}]},
  "spacing": {
    "captured_median_m": 0.0625, "captured_max_m": 0.03125, "needed_without_depth_m": 0.01,
    "needed_with_layers": [{"layers": 1, "needed_m": 0.02}, {"layers": 4, "needed_m": null}],
    "needed_by_error_m": 0.06, "measured_up_to_m": 0.07, "needed_with_distances_m": 0.09,
    "stations": 244, "stations_needed_without_depth": 243, "stations_needed_with_distances": 32,
    "held_out": [{"stride": 3, "step_m": 0.05, "views": 24, "psnr_with_distances_db": 38.5,
                  "psnr_without_depth_db": 21.5, "psnr_of_tolerance_db": 35.5,
                  "hidden_share": 0.001}]},
  "connection": {
    "model_k_deg": 72.0,
    "measured": [{"generation": "hlf-vd", "k_deg": 86.0, "e_connect": 4.5}]},
  "storage": {
    "reach_m": 0.55, "panorama_width_px": 1024, "worth_width_px": 2000.5,
    "distance_width_px": 512, "needed_distance_width_px": 256, "share_within_tolerance": 0.998,
    "omega_steps": 200, "omega_bits": 8, "ray_bytes": 1099511627776, "ray_bytes_thinned": 1001,
    "ray_bytes_worth": 1002, "distance_bytes": 1003, "distance_bytes_needed": 1004},
  "thinned": {
    "room": "a \"room\"", "stations": 12, "distance_maps": 7, "bytes": 1000, "views": 49,
    "psnr_db": 37.5, "worst_psnr_db": 30.5}})";

std::string requirements_error(const std::string& text) {
  try {
    requirements_from_json(text, "room.lf/require.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Requirements, EveryMemberIsAKeyOfTheFile) {
  auto written = nlohmann::json::parse(json_text(requirements_document(example())));
  EXPECT_TRUE(written["written_by"].get<std::string>().starts_with("raywalk "));
  written.erase("written_by");
  EXPECT_EQ(written, nlohmann::json::parse(kExampleJson)) << written.dump(1);
}

TEST(Requirements, AreReadAsTheyWereWritten) {
  const std::string text = json_text(requirements_document(example()));
  const RoomRequirements read = requirements_from_json(text, "test");
  EXPECT_EQ(json_text(requirements_document(read)), text);
  EXPECT_EQ(read.tolerance_px, 0.25);
  EXPECT_EQ(read.distance.far_m, kInfinity);
  EXPECT_EQ(read.distance.omega_error_per_m, 0.003);
  EXPECT_EQ(read.layers.by_d_p[1].layers, 25);
  EXPECT_EQ(read.layers.range().max, 2.0);
  EXPECT_EQ(read.spacing.held_out[0].psnr_without_depth_db, 21.5);
  EXPECT_EQ(read.connection.model_k_deg, 72.0);
  EXPECT_EQ(read.connection.measured[0].generation, "hlf-vd");
  EXPECT_EQ(read.storage.ray_bytes, std::uint64_t{1} << 40);
  EXPECT_EQ(read.thinned->room, "a \"room\"");
}

TEST(Requirements, UnknownValuesAreNull) {
  RoomRequirements r = example();
  r.distance.omega_error_per_m.reset();
  r.connection.model_k_deg.reset();
  r.thinned.reset();
  const RoomRequirements read = requirements_from_json(json_text(requirements_document(r)), "test");
  EXPECT_FALSE(read.distance.omega_error_per_m);
  EXPECT_FALSE(read.connection.model_k_deg);
  EXPECT_FALSE(read.thinned);
}

TEST(Requirements, DamageIsReportedWithARemedy) {
  const std::string whole = json_text(requirements_document(example()));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string damaged[] = {"",
                                 "null",
                                 "[]",
                                 "{}",
                                 whole.substr(0, whole.size() / 2),
                                 with("raywalk-require", "other"),
                                 with("\"format_version\": 1", "\"format_version\": \"1\""),
                                 with("\"format_version\": 1", "\"format_version\": 0"),
                                 with("\"tolerance_px\": 0.25", "\"tolerance_px\": 0"),
                                 with("\"tolerance_px\": 0.25", "\"tolerance_px\": null"),
                                 with("\"layers\": 25", "\"layers\": 2.5"),
                                 with("\"layers\": 25", "\"layers\": -25"),
                                 with("\"layers\": 25", "\"layers\": 1e30"),
                                 with("\"omega_min_per_m\": 0.0", "\"omega_min_per_m\": 3"),
                                 with("\"omega_max_per_m\": 2.0", "\"omega_max_per_m\": null"),
                                 with("\"omega_max_per_m\": 2.0", "\"omega_max_per_m\": \"2\""),
                                 with("72.0", "91"),
                                 with("86.0", "44"),
                                 with("\"hlf-vd\"", "3"),
                                 with("\"held_out\"", "\"held_in\""),
                                 with("1099511627776", "-1")};
  for (const std::string& text : damaged) {
    EXPECT_THAT(requirements_error(text), AllOf(HasSubstr("room.lf/require.json: "),
                                                HasSubstr("run raywalk-build-lf require")))
        << text;
  }
}

TEST(Requirements, NewerVersionIsNamed) {
  std::string text = json_text(requirements_document(example()));
  const std::string version = "\"format_version\": 1";
  text.replace(text.find(version), version.size(), "\"format_version\": 2");
  EXPECT_THAT(requirements_error(text), HasSubstr("format version 2 is newer than 1"));
}

class CurrentRequirements : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  void keep(const RoomRequirements& requirements) const {
    write_file_atomically(requirements_path(path_), json_text(requirements_document(requirements)));
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(CurrentRequirements, AreInvalidatedByNewDistances) {
  Room room = room_of({.width = 32});
  EXPECT_FALSE(current_requirements(room));
  RoomRequirements measured = example();
  measured.distances_sha256 = distances_sha256(room);
  keep(measured);
  ASSERT_TRUE(current_requirements(room));
  EXPECT_EQ(current_requirements(room)->tolerance_px, 0.25);

  SyntheticRoomSpec other{.width = 32};
  other.scene.walls.max_m.x() += 0.01;
  room = room_of(other);
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "different distances";
  room = room_of({.width = 32, .distance_every = 2});
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "fewer distances";
}

TEST_F(CurrentRequirements, DamagedFileIsAnError) {
  const Room room = room_of({.width = 32});
  write_file_atomically(requirements_path(path_), "damaged");
  EXPECT_THROW(current_requirements(room), Error);
}

}  // namespace
}  // namespace raywalk
