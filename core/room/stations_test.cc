// What belongs to the stations of a room: distances, gains, and subsets of them.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/test_support.h"
#include "core/room/distance_maps.h"
#include "core/room/distance_volume.h"
#include "core/room/gain_fields.h"
#include "core/room/hdf5_file.h"
#include "core/room/kept_stations.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;
namespace fs = std::filesystem;
using ::testing::Each;
using ::testing::IsSupersetOf;
using ::testing::SizeIs;

constexpr PanoramaSize kLeftOutSize{8, 4};

TEST(LeftOutPixels, AreFoundByStationAndColumn) {
  const std::vector<std::int32_t> runs = {2, 7, 3, 4, 1, 3, 2, 4, 1, 3, 0, 1, 1, 0, 0, 4};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_FALSE(pixels.any(0));
  EXPECT_TRUE(pixels.any(1));
  EXPECT_FALSE(pixels.any(3));
  EXPECT_THAT(pixels.rows(1, 0), ElementsAre(RowRun{0, 4}));
  EXPECT_THAT(pixels.rows(1, 1), IsEmpty());
  EXPECT_THAT(pixels.rows(1, 3), ElementsAre(RowRun{0, 1}, RowRun{2, 4}));
  EXPECT_THAT(pixels.rows(2, 7), ElementsAre(RowRun{3, 4}));
  EXPECT_THAT(pixels.rows(0, 7), IsEmpty());
}

TEST(LeftOutPixels, FollowASubsetOfTheStations) {
  const std::vector<std::int32_t> runs = {1, 0, 0, 4, 3, 5, 1, 2};
  const std::vector<int> kept = {0, 2, 3};
  const LeftOutPixels pixels = LeftOutPixels(runs, kLeftOutSize, 4, "a.h5").subset(kept);
  EXPECT_FALSE(pixels.any(0));
  EXPECT_FALSE(pixels.any(1));
  EXPECT_THAT(pixels.rows(2, 5), ElementsAre(RowRun{1, 2}));
}

TEST(LeftOutPixels, AreStoredForPanoramasOfAnotherSize) {
  const std::vector<std::int32_t> runs = {1, 3, 1, 3};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_EQ(pixels.stored_runs(kLeftOutSize), runs);
  EXPECT_THAT(pixels.stored_runs({4, 2}), ElementsAre(1, 1, 0, 2));
  EXPECT_THAT(pixels.stored_runs({16, 8}), ElementsAre(1, 6, 2, 6, 1, 7, 2, 6));
}

TEST(LeftOutPixels, RunsOutsideThePanoramaOrTheLineAreRefused) {
  for (const std::vector<std::int32_t>& runs : std::vector<std::vector<std::int32_t>>{
           {4, 0, 0, 1}, {-1, 0, 0, 1}, {0, 8, 0, 1}, {0, 0, 2, 2}, {0, 0, 0, 5}, {0, 0, 0}}) {
    EXPECT_THAT([&] { LeftOutPixels(runs, kLeftOutSize, 4, "a.h5"); },
                ThrowsMessage<Error>(HasSubstr("a.h5: 'left_out'")));
  }
}

TEST(InverseMap, SamplesDoNotMixSurfaces) {
  InverseMap map({64, 32});
  for (int theta = 0; theta < 64; ++theta) {
    for (int row = 0; row < 32; ++row) map.at(theta, row) = theta < 32 ? 1.0f : 0.1f;
  }
  EXPECT_EQ(map.sample({31.4, 10.0}), 1.0f);
  EXPECT_EQ(map.sample({31.6, 10.0}), 0.1f);
  map.at(31, 10) = -1.0f;
  EXPECT_LT(map.sample({31.4, 10.0}), 0.0f);
}

Room room_of(const SyntheticRoomSpec& spec, const TestDirectory& directory) {
  write_synthetic_room(spec, directory / "room.lf");
  return Room::open(directory / "room.lf");
}

TEST(DistanceSamples, WeightsAreSolidAngle) {
  const TestDirectory directory;
  const DistanceSamples known = sample_distances(room_of({.width = 64}, directory), 1 << 20);
  EXPECT_NEAR(known.known_share, 1.0, 1e-6);
  double pixels = 0.0;
  for (const DistanceSample& sample : known.samples) pixels += sample.weight;
  // All maps have 64 x 32 pixels; their weights are the cosines of their rows, 2 / pi on average.
  EXPECT_NEAR(pixels / static_cast<double>(known.samples.size()), 2.0 / kPi, 1e-3);
}

TEST(DistanceSamples, FewMatchTheFullStatistics) {
  const TestDirectory directory;
  const Room room = room_of({.width = 128}, directory);
  const std::array shares{0.05, 0.5, 0.95};
  DistanceSamples some = sample_distances(room, 500), all = sample_distances(room, 1 << 20);
  EXPECT_LT(10 * some.samples.size(), all.samples.size());
  const std::vector<double> few = distance_quantiles(some.samples, shares);
  const std::vector<double> many = distance_quantiles(all.samples, shares);
  for (size_t i = 0; i < shares.size(); ++i) EXPECT_NEAR(few[i], many[i], 0.05 * many[i]);
}

TEST(DistanceQuantiles, AreWeightedAndManyEqualDistancesAreOne) {
  std::vector<DistanceSample> many(1000, {.distance_m = 2.5f, .weight = 0.25f});
  EXPECT_THAT(distance_quantiles(many, std::array{0.01, 0.99}), ElementsAre(2.5, 2.5));
  std::vector<DistanceSample> samples{{.distance_m = 3.0f, .weight = 1.0f},
                                      {.distance_m = 1.0f, .weight = 8.0f},
                                      {.distance_m = INFINITY, .weight = 1.0f}};
  EXPECT_THAT(distance_quantiles(samples, std::array{0.0, 0.5, 0.8, 0.85, 0.95, 1.0}),
              ElementsAre(1.0, 1.0, 1.0, 3.0, INFINITY, INFINITY));
}

TEST(DistanceSamples, RoomWithoutDistancesHasNone) {
  const TestDirectory directory;
  const Room room = room_of({.width = 32, .distances = false}, directory);
  DistanceSamples none = sample_distances(room, 100);
  EXPECT_TRUE(none.samples.empty());
  EXPECT_EQ(none.known_share, 0.0);
  EXPECT_TRUE(std::isnan(distance_quantiles(none.samples, std::array{0.5})[0]));
}

class GainFieldsTest : public ::testing::Test {
 protected:
  GainFieldsTest() { write_synthetic_room({.spacing_m = 0.5, .width = 16}, room_); }

  // A whole gain at x0/0, a local field at z1/2.
  GainFields some_fields() const {
    GainFields fields = unit_gain_fields(grid_);
    fields[0][0].whole = {0.5F, 1.0F, 1.25F};
    cv::Mat local(4, 2, CV_32FC3, cv::Scalar::all(1.0));
    local.at<cv::Vec3f>(3, 1) = {1.5F, 1.0F, 0.75F};
    fields.back()[2].local = local;
    return fields;
  }

  void record() const {
    RoomManifest manifest = read_manifest(room_);
    manifest.gains = true;
    write_file_atomically(manifest_path(room_), manifest_to_json(manifest));
  }

  std::string reading() const {
    return error_of([&] { read_gain_fields(gains_path(room_), grid_); });
  }
  std::string opening() const {
    return error_of([&] { Room::open(room_); });
  }

  // A file with the given values for every station and channel.
  void write_values(const std::vector<double>& values, const Shape& shape,
                    int version = kVolumeFormatVersion) const {
    write_gain_fields(gains_path(room_), grid_, some_fields());
    const auto stations = Hdf5File::open(gains_path(room_)).text_attribute("stations_sha256");
    Hdf5File file = Hdf5File::create(gains_path(room_));
    file.write_format(kGainsFormat, version);
    file.write_attribute("/", "stations_sha256", stations.value());
    file.write_attribute("/", "sha256", sha256_hex(std::as_bytes(std::span(values))));
    file.write("gain", values, shape);
    file.close();
  }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
  Grid grid_ = synthetic_grid({.spacing_m = 0.5});
};

TEST_F(GainFieldsTest, OfAnotherRoomAreRefused) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  Grid fewer = grid_, renamed = grid_;
  fewer.lines[2].stations.pop_back();
  renamed.lines[2].id = "z5";
  for (const Grid& other : {fewer, renamed}) {
    EXPECT_THAT(error_of([&] { read_gain_fields(gains_path(room_), other); }),
                HasSubstr("of other stations"));
  }
}

TEST_F(GainFieldsTest, OutOfRangeAreRefused) {
  for (const double bad : {0.0, -1.0, 17.0, 0.06, std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<double> values(36, 1.0);
    values[7] = bad;
    write_values(values, {12, 1, 1, 3});
    EXPECT_THAT(reading(), HasSubstr("its gains are damaged")) << bad;
  }
  write_values(std::vector<double>(36, 1.0), {12, 1, 1, 3});
  EXPECT_EQ(reading(), "no error");
}

TEST_F(GainFieldsTest, OfAnotherShapeOrVersionAreRefused) {
  write_values(std::vector<double>(36, 1.0), {12, 3, 1, 1});
  EXPECT_THAT(reading(), HasSubstr("'gain' is not [12 stations][theta][phi][3]"));
  write_values(std::vector<double>(33, 1.0), {11, 1, 1, 3});
  EXPECT_THAT(reading(), HasSubstr("'gain' is not [12 stations]"));
  write_values(std::vector<double>(36, 1.0), {12, 1, 1, 3}, kVolumeFormatVersion + 1);
  EXPECT_THAT(reading(), HasSubstr("version"));
  fs::remove(gains_path(room_));
  EXPECT_THAT(reading(), HasSubstr("gains.h5"));
}

TEST_F(GainFieldsTest, AreUsedOnlyAsRecorded) {
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
  write_gain_fields(gains_path(room_), grid_, some_fields());
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
  record();
  EXPECT_THAT(Room::open(room_).gains(), SizeIs(4));
  EXPECT_EQ(Room::open(room_).gains()[0][0].whole, ColourGain(0.5F, 1.0F, 1.25F));
  EXPECT_THAT(Room::open_without_gains(room_).gains(), IsEmpty());
  fs::remove(gains_path(room_));
  EXPECT_THAT(opening(), HasSubstr("gains.h5"));
  EXPECT_THAT(opening(), HasSubstr("raywalk-build-lf gains"));
}

// Bytes that hold nothing may differ.
TEST_F(GainFieldsTest, AreReadAsTheyWereOrRefusedWithAnyByteDamaged) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  record();
  const std::string whole = read_file(gains_path(room_));
  const Room intact = Room::open(room_);
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += 37) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    std::ofstream(gains_path(room_), std::ios::binary) << damaged;
    if (const std::string error = opening(); error != "no error") {
      EXPECT_EQ(error.find('\n'), std::string::npos) << i;
      ++refused;
      continue;
    }
    const Room room = Room::open(room_);
    EXPECT_EQ(room.gains()[0][0].whole, intact.gains()[0][0].whole) << i;
    EXPECT_EQ(cv::norm(room.gains()[3][2].local, intact.gains()[3][2].local), 0.0) << i;
  }
  EXPECT_GT(refused, 20);
  std::ofstream(gains_path(room_), std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_THAT(opening(), HasSubstr("gains.h5"));
}

TEST_F(GainFieldsTest, AreReadAsWrittenAndGoWithTheirStations) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  record();
  const Room part = Room::open(room_).subset({{0, 2}, {0, 1}, {0, 1}, {1, 2}});
  ASSERT_THAT(part.gains(), SizeIs(4));
  EXPECT_THAT(part.gains()[0], SizeIs(2));
  EXPECT_EQ(part.gains()[0][0].whole, ColourGain(0.5F, 1.0F, 1.25F));
  EXPECT_TRUE(part.gains()[0][0].local.empty());
  EXPECT_TRUE(is_one(part.gains()[3][0]));
  EXPECT_EQ(part.gains()[3][1].whole, ColourGain(1.0F, 1.0F, 1.0F));
  EXPECT_EQ(cv::norm(part.gains()[3][1].local, some_fields()[3][2].local, cv::NORM_INF), 0.0);
}

constexpr double kNoLimit_m = std::numeric_limits<double>::infinity();

// A single line with stations at the given positions.
Grid line_of(const std::vector<double>& along_m) {
  Grid grid = synthetic_grid({.cells_z = 0});
  grid.lines[0].stations.clear();
  for (const double along : along_m) {
    grid.lines[0].stations.push_back({.file = {}, .position_m = {along, 0, 0}, .along_m = along});
  }
  return grid;
}

// Lines of nine stations, maps at every second one.
class KeptStationsTest : public ::testing::Test {
 protected:
  TestDirectory directory_;
  Room room_ = room_of({.width = 16, .distance_every = 2}, directory_);
};

TEST_F(KeptStationsTest, HeldOutAndKeptStationsPartitionTheRoom) {
  for (int every = 2; every < 12; ++every) {
    const auto left_out = held_out_stations(room_.grid(), every);
    const KeptStations kept = stations_except(room_.grid(), left_out);
    for (std::size_t line = 0; line < kept.size(); ++line) {
      std::vector<int> all;
      std::ranges::merge(kept[line], left_out[line], std::back_inserter(all));
      EXPECT_THAT(all, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
      EXPECT_EQ(kept[line].front(), 0);
      EXPECT_EQ(kept[line].back(), 8);
      for (std::size_t i = 1; i < left_out[line].size(); ++i) {
        EXPECT_EQ(left_out[line][i] - left_out[line][i - 1], every);
      }
    }
  }
  EXPECT_THAT(held_out_stations(room_.grid(), 4), Each(ElementsAre(2, 6)));
}

TEST_F(KeptStationsTest, SubsetHasTheSameRaysAndMaps) {
  const std::vector<int> kept{0, 3, 4, 8};
  const Room part = room_.subset({kept, kept, kept, kept});
  // A part of a part counts from its own stations.
  const Room smaller = part.subset({{0, 2}, {0, 2}, {0, 2}, {0, 2}});
  for (int line = 0; line < 4; ++line) {
    const auto at = static_cast<std::size_t>(line);
    ASSERT_THAT(part.grid().lines[at].stations, SizeIs(4));
    ASSERT_EQ(part.volume(line).stations(), 4);
    for (int i = 0; i < 4; ++i) {
      const int whole = kept[static_cast<std::size_t>(i)];
      EXPECT_EQ(part.volume(line).column(i, 5).data(), room_.volume(line).column(whole, 5).data());
      EXPECT_EQ(part.grid().lines[at].stations[static_cast<std::size_t>(i)].file,
                room_.grid().lines[at].stations[static_cast<std::size_t>(whole)].file);
    }
    EXPECT_THAT(part.distances(line).stations(), ElementsAre(0, 2, 3));
    EXPECT_EQ(part.distances(line).distance_column(1, 7).data(),
              room_.distances(line).distance_column(2, 7).data());
    EXPECT_EQ(part.distances(line).confidence_column(2, 7).data(),
              room_.distances(line).confidence_column(4, 7).data());
    EXPECT_EQ(smaller.volume(line).column(1, 3).data(), room_.volume(line).column(4, 3).data());
    EXPECT_THAT(smaller.distances(line).stations(), ElementsAre(0, 1));
    EXPECT_EQ(smaller.distances(line).distance_column(1, 0).data(),
              room_.distances(line).distance_column(2, 0).data());
  }
  EXPECT_EQ(part.grid().cells.size(), 1U);
}

TEST_F(KeptStationsTest, InvalidSubsetsAreRejected) {
  const std::vector<int> two{0, 8};
  EXPECT_NO_THROW(room_.subset({two, two, two, two}));
  EXPECT_THROW(room_.subset({two, two, two}), UsageError);
  for (const std::vector<int>& wrong : KeptStations{{3}, {3, 3}, {8, 0}, {0, 9}, {-1, 8}}) {
    EXPECT_THROW(room_.subset({two, two, two, wrong}), UsageError);
  }
}

TEST_F(KeptStationsTest, WithDistancesReplacesTheMaps) {
  write_synthetic_room({.width = 16, .distance_every = 4}, directory_ / "other.lf");
  const Room room =
      room_.with_distances(distances_directory(directory_ / "other.lf", DistanceKind::kGiven));
  EXPECT_THAT(room.distances(0).stations(), ElementsAre(0, 4, 8));
  EXPECT_EQ(room.volume(2).column(8, 1).data(), room_.volume(2).column(8, 1).data());
  EXPECT_THROW(room_.with_distances(directory_ / "nowhere"), Error);
}

TEST(NeededStations, LeaveNoGapWiderThanTheSpacing) {
  const Grid grid = line_of({0, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_THAT(needed_stations(grid, 0, 1.99, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, 2.0, {}), ElementsAre(0, 2, 4, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, 3.0, {}), ElementsAre(0, 3, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, kNoLimit_m, {}), ElementsAre(0, 7));
  EXPECT_THAT(needed_stations(line_of({0, 1}), 0, kNoLimit_m, {}), ElementsAre(0, 1));
  std::vector<double> along;
  for (int i = 0; i < 31; ++i) along.push_back(0.1 * i);
  EXPECT_EQ(needed_stations(line_of(along), 0, 0.3, {}).size(), 11U) << "robust to rounding";
}

TEST(NeededStations, DependOnTheWidthOfGapsNotTheirNumber) {
  const Grid grid = line_of({0, 0.1, 0.2, 1.0, 3.0, 3.1, 3.2});
  EXPECT_THAT(needed_stations(grid, 0, 1.0, {}), ElementsAre(0, 3, 4, 6));
  EXPECT_THAT(needed_stations(grid, 0, 0.05, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6))
      << "nothing is left out where the line is too coarse already";
}

TEST(NeededStations, StationsWithDistancesArePreferred) {
  const Grid grid = line_of({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  EXPECT_THAT(needed_stations(grid, 0, 3.0, std::array{0, 2, 4, 6, 8}), ElementsAre(0, 2, 4, 6, 9));
  EXPECT_THAT(needed_stations(grid, 0, 3.0, std::array{4}), ElementsAre(0, 3, 4, 7, 9));
}

TEST(NeededStations, IntersectionsAreKept) {
  // Cells of 1 m, lines reach 0.25 m beyond them: intersections at stations 2, 10 and 18 of 21.
  const SyntheticRoomSpec spec{
      .cells_x = 2, .cells_z = 2, .side_m = 1.0, .spacing_m = 0.125, .overhang_m = 0.25};
  const Grid grid = synthetic_grid(spec);
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    EXPECT_THAT(needed_stations(grid, line, kNoLimit_m, {}), ElementsAre(0, 2, 10, 18, 20));
    EXPECT_THAT(needed_stations(grid, line, 0.6, {}), IsSupersetOf({0, 2, 10, 18, 20}));
  }
}

}  // namespace
}  // namespace raywalk
