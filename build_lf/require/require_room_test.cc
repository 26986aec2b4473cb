#include "build_lf/require/require_room.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "build_lf/exposure/make_gains.h"
#include "build_lf/quality/room_verify.h"
#include "build_lf/require/test_distances.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"
#include "core/geometry/spacing.h"
#include "core/geometry/test_pixels.h"
#include "core/room/gain_fields.h"
#include "core/room/requirements.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class RequireRoomTest : public RequireTest {
 protected:
  // A cell of 1 m with an overhang of 0.25 m: 13 stations per line.
  static SyntheticRoomSpec spec() {
    return {.side_m = 1.0, .spacing_m = 0.125, .overhang_m = 0.25, .width = 128};
  }
  // A single line of 17 stations, for speed.
  static SyntheticRoomSpec line_spec() {
    return {.cells_z = 0, .side_m = 2.0, .spacing_m = 0.125, .width = 128};
  }
  // The line under an open sky.
  static SyntheticRoomSpec sky_spec() {
    SyntheticRoomSpec spec = line_spec();
    spec.scene.infinitely_far = true;
    return spec;
  }
  nlohmann::json kept() const { return nlohmann::json::parse(read_file(requirements_path(path_))); }
  // What is kept of a run that thins a room.
  nlohmann::json thinned(const SyntheticRoomSpec& spec) const {
    room_of(spec);
    require_room({.room = path_, .thin = thin_, .report = report_});
    return kept();
  }
  std::string error_of(const RequireOptions& options) const {
    std::string message = raywalk::error_of([&] { require_room(options); });
    EXPECT_THAT(message, ::testing::Not(HasSubstr("\n")));
    return message;
  }
  // Leaves only one distance map in a room of one line, at `station`.
  static void give_distances_to(int station, const Room& room) {
    const Line& line = room.grid().lines[0];
    const DistanceVolume& volume = room.distances(0);
    Progress progress("replacing", 1, "maps");
    write_distance_volume(
        distance_volume_path(room.directory(), line.id), line,
        {{station}, volume.size(), "one", [&](size_t) { return stored_distances(volume, 0); }},
        &progress);
  }

  fs::path thin_ = directory_ / "thin.lf";
  fs::path report_ = directory_ / "report";
};

TEST_F(RequireRoomTest, StoresTheResultInRoomAndReport) {
  const Room room = room_of(spec());
  const std::string told = require_room({.room = path_, .report = report_});
  EXPECT_THAT(told, AllOf(HasSubstr("52"), HasSubstr("index.html")));
  const nlohmann::json r = kept();
  EXPECT_EQ(read_file(report_ / "require.json"), read_file(requirements_path(path_)));
  EXPECT_THAT(read_file(report_ / "index.html"), HasSubstr("\"kind\":\"require\""));
  ASSERT_TRUE(current_requirements(room)) << "it belongs to the room";
  EXPECT_EQ(r["spacing"]["stations"], 52);
  EXPECT_NEAR(r["spacing"]["captured_median_m"].get<double>(), 0.125, 1e-9);
  EXPECT_EQ(r["storage"]["reach_m"], 0.5);
  const double inverse_max = r["layers"]["inverse_max_per_m"], near_m = r["distance"]["near_m"];
  EXPECT_NEAR(inverse_max * near_m, 1.0, 1e-12);
  // The formula, for the measured distances.
  const double tolerance_rad = angle_of_pixels(0.5, 128);
  const InverseRange range{r["layers"]["inverse_min_per_m"], inverse_max};
  EXPECT_DOUBLE_EQ(r["spacing"]["needed_without_depth_m"].get<double>(),
                   spacing_needed_without_depth(range, tolerance_rad));
  EXPECT_EQ(r["spacing"]["needed_with_layers"].front()["layers"], 1);
  // An empty room with exact distances: nearly everything could be left out.
  EXPECT_LT(r["spacing"]["stations_needed_with_distances"], 30);
  EXPECT_GE(r["spacing"]["stations_needed_with_distances"], 16)
      << "two ends and two corners of each line";
  EXPECT_EQ(r["spacing"]["stations_needed_without_depth"], 52);
  EXPECT_TRUE(r["thinned"].is_null());
  // What the report shows besides.
  EXPECT_EQ(r["room"], path_.string());
  EXPECT_EQ(r["lines"], 4);
  ASSERT_EQ(r["stations"].size(), 52U);
  EXPECT_EQ(std::ranges::count_if(r["stations"], [](const auto& s) { return s["kept"] == true; }),
            r["spacing"]["stations_needed_with_distances"]);
  const Station& last = room.grid().lines.back().stations.back();
  EXPECT_EQ(r["stations"].back()["x_m"], last.position_m.x());
  EXPECT_EQ(r["stations"].back()["z_m"], last.position_m.z());
  EXPECT_EQ(r["surroundings"].size(), 8U);
  EXPECT_EQ(r["surroundings"][0]["distances_m"].size(), 180U);
  EXPECT_GT(r["surroundings"][0]["distances_m"][90], 0.5);
}

TEST_F(RequireRoomTest, LooserToleranceRequiresLess) {
  const Room room = room_of(line_spec());
  const SceneFacts strict = measure_requirements(room, 0.25);
  const SceneFacts loose = measure_requirements(room, 2.0);
  EXPECT_NEAR(loose.spacing.needed_without_depth_m / strict.spacing.needed_without_depth_m, 8.0,
              0.1);
  EXPECT_LT(loose.layers.by_d_p.back().layers, strict.layers.by_d_p.back().layers);
  EXPECT_GE(loose.spacing.needed_with_distances_m, strict.spacing.needed_with_distances_m);
}

TEST_F(RequireRoomTest, BadDistancesRequireMoreStations) {
  const SceneFacts right = measure_requirements(room_of(line_spec()), 0.25);
  replace_distances([](float metres) { return 1.3f * metres; });
  const SceneFacts wrong = measure_requirements(Room::open(path_), 0.25);
  EXPECT_GT(wrong.spacing.stations_needed_with_distances,
            right.spacing.stations_needed_with_distances);
}

TEST_F(RequireRoomTest, ThinnedRoomIsARoomWithTheSameRays) {
  const Room room = room_of(spec());
  require_room({.room = path_, .thin = thin_});
  const nlohmann::json r = kept(), thinned = r["thinned"];
  const Room thin = Room::open(thin_);
  const VerifiedCounts counts = verify_room(thin);
  EXPECT_EQ(counts.panoramas, r["spacing"]["stations_needed_with_distances"]);
  expect_keys(thinned, {{"stations", counts.panoramas}, {"distance_maps", counts.distance_maps}});
  EXPECT_GT(thinned["psnr_db"], 30.0);
  EXPECT_LE(thinned["worst_psnr_db"], thinned["psnr_db"]);
  EXPECT_GT(thinned["views"], 0);
  ASSERT_EQ(thin.grid().cells.size(), 1U);
  for (int line = 0; line < 4; ++line) {
    const Line& before = room.grid().lines[line];
    const Line& after = thin.grid().lines[line];
    EXPECT_EQ(after.id, before.id);
    EXPECT_EQ(after.first_m(), before.first_m());
    EXPECT_EQ(after.last_m(), before.last_m());
    EXPECT_EQ(thin.distances(line).maps(), static_cast<int>(after.stations.size()));
    std::vector<std::string> files;
    for (size_t i = 0; i < after.stations.size(); ++i) {
      files.push_back(after.stations[i].file);
      const auto same = std::ranges::find(before.stations, files.back(), &Station::file);
      ASSERT_NE(same, before.stations.end());
      const auto old = same - before.stations.begin();
      EXPECT_TRUE(
          std::ranges::equal(thin.volume(line).column(i, 17), room.volume(line).column(old, 17)));
    }
    // The corners lie 0.25 m from the ends.
    EXPECT_THAT(files,
                AllOf(Contains(before.stations[2].file), Contains(before.stations[10].file)));
  }
}

TEST_F(RequireRoomTest, ThinnedRoomStoresDistancesAsFineAsNeeded) {
  SyntheticRoomSpec fine = line_spec();
  fine.width = 256;
  const nlohmann::json r = thinned(fine);
  const Room thin = Room::open(thin_);
  const DistanceVolume& maps = thin.distances(0);
  EXPECT_EQ(maps.size().width, r["storage"]["needed_distance_width_px"]);
  EXPECT_LT(maps.size().width, 256) << "an empty room has smooth distances";
  const double most = angle_of_pixels(0.5, 256) / r["storage"]["reach_m"].get<double>();
  int right = 0, all = 0;
  for (int map = 0; map < maps.maps(); ++map) {
    const Eigen::Vector3d& from = thin.grid().station({0, maps.stations()[map]}).position_m;
    for (const auto [theta, row] : pixels_of(maps.size())) {
      const Eigen::Vector3d direction = direction_from_angles(
          angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, maps.size()));
      const double metres = maps.distance_column(map, theta)[row];
      const double error = 1.0 / metres - 1.0 / distance_at(fine.scene, from, direction);
      if (std::abs(error) <= most) ++right;
      ++all;
    }
  }
  EXPECT_GT(right, 0.99 * all);
}

TEST_F(RequireRoomTest, LossIsMeasuredOnDroppedStations) {
  room_of(line_spec());
  replace_distances([](float metres) { return 1.1f * metres; });
  require_room({.room = path_, .tolerance_px = 4.0, .thin = thin_});
  const nlohmann::json loose = kept();
  fs::remove_all(thin_);
  require_room({.room = path_, .tolerance_px = 0.1, .thin = thin_});
  const nlohmann::json strict = kept();
  EXPECT_LT(loose["thinned"]["stations"], strict["thinned"]["stations"]);
  EXPECT_LT(loose["thinned"]["psnr_db"], strict["thinned"]["psnr_db"]);
  EXPECT_LT(loose["thinned"]["bytes"], strict["thinned"]["bytes"]);
}

TEST_F(RequireRoomTest, ThinnedRoomKeepsItsGainsAndTheOriginOfItsDistances) {
  const Room room = room_of(line_spec());
  replace_distances([](float metres) { return metres; });  // of origin "changed"
  GainFields gains = unit_gain_fields(room.grid());
  gains[0][0].whole = ColourGain::all(1.25F);
  replace_gains(path_, gains);
  require_room({.room = path_, .thin = thin_});
  const Room thin = Room::open(thin_);
  EXPECT_EQ(thin.gains()[0][0].whole, ColourGain::all(1.25F));
  EXPECT_EQ(thin.distances_origin(), "changed");
}

TEST_F(RequireRoomTest, LinesOfTwoStationsAreKeptWhole) {
  SyntheticRoomSpec two = spec();
  two.spacing_m = 1.0;
  two.overhang_m = 0.0;
  const nlohmann::json r = thinned(two);
  expect_keys(r["spacing"], {{"stations", 8},
                             {"stations_needed_with_distances", 8},
                             {"held_out", nlohmann::json::array()},
                             {"measured_up_to_m", 0.0}});
  expect_keys(r["thinned"], {{"views", 0}, {"psnr_db", 100.0}});
  EXPECT_EQ(verify_room(Room::open(thin_)).panoramas, 8);
}

TEST_F(RequireRoomTest, OpenSkyRequiresNothing) {
  const nlohmann::json r = thinned(sky_spec());
  EXPECT_TRUE(r["spacing"]["needed_without_depth_m"].is_null());
  EXPECT_EQ(r["layers"]["by_d_p"].back()["layers"], 1);
  EXPECT_TRUE(r["storage"]["worth_width_px"].is_null());
}

TEST_F(RequireRoomTest, MapsOnSomeStationsSuffice) {
  SyntheticRoomSpec sparse = line_spec();
  sparse.distance_every = 6;
  sparse.distance_width = 64;
  thinned(sparse);
  EXPECT_GT(verify_room(Room::open(thin_)).distance_maps, 0);
}

// The line's ends suffice for an open sky; the one map lies between them.
TEST_F(RequireRoomTest, ThinningWithoutAnyDistanceMapIsRejected) {
  give_distances_to(8, room_of(sky_spec()));
  EXPECT_THAT(error_of({.room = path_, .thin = thin_}),
              AllOf(HasSubstr("--thin"), HasSubstr("raywalk-build-lf depth")));
  EXPECT_FALSE(fs::exists(thin_));
  EXPECT_FALSE(fs::exists(requirements_path(path_))) << "told before anything is written";
  EXPECT_EQ(error_of({.room = path_}), "no error");
}

// If thinning fails, the measurement is still stored.
TEST_F(RequireRoomTest, MeasurementIsKeptIfThinningFails) {
  room_of(line_spec());
  fs::create_directory(thin_.string() + ".partial");
  std::ofstream(thin_.string() + ".partial/lines") << "a file in the way";
  EXPECT_NE(error_of({.room = path_, .thin = thin_}), "no error");
  EXPECT_TRUE(kept()["thinned"].is_null());
}

TEST_F(RequireRoomTest, ToleranceMustBeANumberOfPixels) {
  room_of({.width = 32});
  for (const double tolerance_px : {std::nan(""), 0.0, -1.0, 101.0, HUGE_VAL}) {
    EXPECT_THROW(require_room({.room = path_, .tolerance_px = tolerance_px}), UsageError);
  }
  EXPECT_FALSE(fs::exists(requirements_path(path_)));
}

TEST_F(RequireRoomTest, NothingIsOverwritten) {
  room_of(line_spec());
  fs::create_directory(thin_);
  EXPECT_THAT(error_of({.room = path_, .thin = thin_}),
              AllOf(HasSubstr(thin_.string()), HasSubstr("exists already")));
  EXPECT_TRUE(fs::is_empty(thin_));
  EXPECT_FALSE(fs::exists(requirements_path(path_))) << "told before any work";
}

TEST_F(RequireRoomTest, ReportAndThinnedRoomAreNotTheSameDirectory) {
  room_of(line_spec());
  EXPECT_THAT(error_of({.room = path_, .thin = report_, .report = report_}),
              AllOf(HasSubstr(report_.string()), HasSubstr("exists already")));
  EXPECT_THAT(error_of({.room = path_, .thin = thin_, .report = thin_ / "report"}),
              AllOf(HasSubstr(thin_.string()), HasSubstr("another --thin")));
  EXPECT_FALSE(fs::exists(requirements_path(path_))) << "told before any work";
}

TEST_F(RequireRoomTest, UnwritableOutputsFailBeforeAnyWork) {
  room_of({.width = 32});
  std::ofstream(report_) << "a file in the way";
  EXPECT_THAT(error_of({.room = path_, .report = report_}), HasSubstr(report_.string()));
  EXPECT_THAT(error_of({.room = path_, .thin = directory_ / "nowhere" / "thin.lf"}),
              HasSubstr("nowhere"));
  fs::remove(report_);
  fs::create_directories(report_ / "require.json");
  EXPECT_THAT(error_of({.room = path_, .report = report_}),
              HasSubstr((report_ / "require.json").string()));
  EXPECT_FALSE(fs::exists(requirements_path(path_)));
  fs::create_directory(requirements_path(path_));
  EXPECT_THAT(error_of({.room = path_}), HasSubstr("require.json"));
}

}  // namespace
}  // namespace raywalk::build_lf
