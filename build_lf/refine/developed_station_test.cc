#include "build_lf/refine/developed_station.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

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
