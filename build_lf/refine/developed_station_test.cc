#include "build_lf/refine/developed_station.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
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

TEST(DevelopedStationTest, IsStoredAsItIs) {
  const TestDirectory directory;
  for (const bool masked : {false, true}) {
    const DevelopedStation station = station_of(masked);
    store_developed(directory / "a.developed", station);
    const DevelopedStation loaded = load_developed(directory / "a.developed", 8);
    EXPECT_EQ(loaded.rays.rays, station.rays.rays);
    EXPECT_EQ(loaded.rays.valid_rows, station.rays.valid_rows);
    EXPECT_EQ(loaded.distances.distance_m, station.distances.distance_m);
    EXPECT_EQ(loaded.distances.confidence, station.distances.confidence);
    EXPECT_EQ(loaded.distances.sha256,
              checksum_of_distances(station.distances.distance_m, station.distances.confidence));
    EXPECT_EQ(stored_sharpening(directory / "a.developed"), 1.25);
  }
}

TEST(DevelopedStationTest, DamageIsNoticed) {
  const TestDirectory directory;
  store_developed(directory / "a.developed", station_of(true));
  const std::string text = read_file(directory / "a.developed");
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{7}, text.size() / 2}) {
    write_file_atomically(directory / "a.developed", text.substr(0, bytes));
    EXPECT_THROW(load_developed(directory / "a.developed", 8), Error) << bytes;
  }
  write_file_atomically(directory / "a.developed", text + "more");
  EXPECT_THROW(load_developed(directory / "a.developed", 8), Error);
}

}  // namespace
}  // namespace raywalk::build_lf
