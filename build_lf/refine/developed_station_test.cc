#include "build_lf/refine/developed_station.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

DevelopedStation station_of(bool masked) {
  DevelopedStation station;
  station.sharpening = 1.25;
  for (int i = 0; i < 8 * 4; ++i) {
    for (int c = 0; c < 3; ++c) station.rays.rays.push_back(static_cast<std::uint8_t>(3 * i + c));
    station.distances.distance_m.push_back(0.5f * static_cast<float>(i));
    station.distances.confidence.push_back(static_cast<std::uint8_t>(255 - i));
  }
  if (masked) station.rays.valid_rows.assign(16, 3);
  return station;
}

// The station in the middle of a line of a room whose maps have these confidences.
DevelopedStation developed_with(const std::function<std::uint8_t(int u, int v)>& confidence,
                                int every = 1) {
  const TestDirectory directory;
  SyntheticRoomSpec spec;
  spec.cells_z = 0;
  spec.distance_every = every;
  spec.stored_confidence = confidence;
  write_synthetic_room(spec, directory / "room.lf");
  const Room room = Room::open(directory / "room.lf");
  SourceViews views(room);
  return develop_station(room, nullptr, {0, 3}, 256, &views);
}

TEST(DevelopedStationTest, SinglePixelsOfLowConfidenceAreBelieved) {
  const DevelopedStation station = developed_with(
      [](int u, int v) -> std::uint8_t { return u % 4 == 0 && v % 4 == 0 ? 20 : 255; });
  const auto& confidence = station.distances.confidence;
  EXPECT_EQ(*std::ranges::min_element(confidence), kMinConfidence);
  EXPECT_EQ(*std::ranges::max_element(confidence), 240);
  EXPECT_GT(*std::ranges::min_element(station.distances.distance_m), 1.0f);
}

TEST(DevelopedStationTest, DistancesHaveTheBitsThatViewsNeed) {
  const DevelopedStation station = developed_with([](int, int) -> std::uint8_t { return 255; });
  // 256 px: a quarter of a pixel is a 163rd of 1 m from 1 m aside, so there are 8 bits.
  std::set<float> fractions;
  for (const float metres : station.distances.distance_m) {
    int exponent = 0;
    const float fraction = 256.0f * std::frexp(metres, &exponent);
    EXPECT_EQ(fraction, std::round(fraction));
    fractions.insert(fraction);
  }
  EXPECT_GT(fractions.size(), 100u);
}

TEST(DevelopedStationTest, WhereMostAreOfLowConfidenceNoneIsKnown) {
  // The left half of the panorama.
  const DevelopedStation station =
      developed_with([](int u, int) -> std::uint8_t { return u < 64 ? 20 : 255; });
  const auto known_at = [&](std::size_t u) {
    return station.distances.confidence[u * 128 + 64] >= kMinConfidence;
  };
  for (const std::size_t u : {32u, 64u, 96u}) EXPECT_FALSE(known_at(u)) << u;
  for (const std::size_t u : {160u, 192u, 224u}) EXPECT_TRUE(known_at(u)) << u;
}

TEST(DevelopedStationTest, WithoutAMapOfItsOwnItTakesThoseAround) {
  const DevelopedStation own = developed_with([](int, int) -> std::uint8_t { return 255; });
  const DevelopedStation gathered = developed_with([](int, int) -> std::uint8_t { return 255; }, 2);
  std::size_t near = 0;
  for (std::size_t i = 0; i < own.distances.distance_m.size(); ++i) {
    const float metres = own.distances.distance_m[i];
    near += std::fabs(gathered.distances.distance_m[i] - metres) < 0.02f * metres ? 1 : 0;
  }
  EXPECT_GT(near, own.distances.distance_m.size() * 97 / 100);
}

TEST(DevelopedStationTest, IsStoredAsItIsAndDamageIsNoticed) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "a.h5";
  for (const bool masked : {false, true}) {
    const DevelopedStation station = station_of(masked);
    store_developed(file, station, "made from this");
    EXPECT_EQ(developed_rays(file).rays, station.rays.rays);
    EXPECT_EQ(developed_rays(file).valid_rows, station.rays.valid_rows);
    const StationDistances distances = developed_distances(file);
    EXPECT_EQ(distances.distance_m, station.distances.distance_m);
    EXPECT_EQ(distances.confidence, station.distances.confidence);
    EXPECT_EQ(distances.sha256,
              checksum_of_distances(station.distances.distance_m, station.distances.confidence));
    EXPECT_EQ(developed_sharpening(file), 1.25);
    EXPECT_EQ(inputs_of(file), "made from this");
  }
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_THROW(developed_rays(file), Error);
}

}  // namespace
}  // namespace raywalk::build_lf
