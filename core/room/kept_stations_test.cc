#include "core/room/kept_stations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::SizeIs;

// Lines of nine stations, maps at every second one.
class KeptStationsTest : public ::testing::Test {
 protected:
  KeptStationsTest() {
    SyntheticRoomSpec spec;
    spec.width = 16;
    spec.distance_every = 2;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }
  TestDirectory directory_;
  Room room_;
};

TEST_F(KeptStationsTest, StationsWithMapsArePreferred) {
  EXPECT_THAT(every_nth_station(room_, 1), Each(ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8)));
  EXPECT_THAT(every_nth_station(room_, 2), Each(ElementsAre(0, 2, 4, 6, 8)));
  EXPECT_THAT(every_nth_station(room_, 3), Each(ElementsAre(0, 4, 6, 8)));
  EXPECT_THAT(every_nth_station(room_, 5), Each(ElementsAre(0, 6, 8)));
  EXPECT_THAT(every_nth_station(room_, 9), Each(ElementsAre(0, 8)));
  EXPECT_THAT(every_nth_station(room_, 1 << 30), Each(ElementsAre(0, 8)));
}

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
  EXPECT_THROW(room_.subset({two, two, two, {3}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {3, 3}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {8, 0}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {0, 9}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {-1, 8}}), UsageError);
}

TEST_F(KeptStationsTest, WithDistancesReplacesTheMaps) {
  SyntheticRoomSpec spec;
  spec.width = 16;
  spec.distance_every = 4;
  write_synthetic_room(spec, directory_ / "other.lf");
  const Room room = room_.with_distances(distances_directory(directory_ / "other.lf"));
  EXPECT_THAT(room.distances(0).stations(), ElementsAre(0, 4, 8));
  EXPECT_EQ(room.volume(2).column(8, 1).data(), room_.volume(2).column(8, 1).data());
  EXPECT_FALSE(room_.with_distances(directory_ / "nowhere").has_distances());
}

TEST_F(KeptStationsTest, MapsOfALineCanBeThoseInMemory) {
  std::vector<float> distance_m(2 * 8 * 4, 1.5f);
  std::vector<std::uint8_t> confidence(distance_m.size(), 200);
  distance_m[static_cast<size_t>(8 * 4 + 3 * 4 + 2)] = 7.0f;  // of map 1, column 3, row 2
  confidence[static_cast<size_t>(8 * 4 + 3 * 4 + 2)] = 9;
  const Room room =
      room_.with_distances(1, room_.distances(1).with_maps({3, 4}, {8, 4}, distance_m, confidence));
  const DistanceVolume& maps = room.distances(1);
  EXPECT_THAT(maps.stations(), ElementsAre(3, 4));
  EXPECT_EQ(maps.size(), (PanoramaSize{8, 4}));
  EXPECT_THAT(maps.distance_column(1, 3), ElementsAre(1.5f, 1.5f, 7.0f, 1.5f));
  EXPECT_THAT(maps.confidence_column(1, 3), ElementsAre(200, 200, 9, 200));
  EXPECT_THAT(maps.distance_column(0, 7), Each(1.5f));
  EXPECT_THAT(maps.subset(std::vector<int>{4, 5}).distance_column(0, 3),
              ElementsAre(1.5f, 1.5f, 7.0f, 1.5f));
  EXPECT_EQ(room.distances(0).distance_column(0, 0).data(),
            room_.distances(0).distance_column(0, 0).data())
      << "other lines keep theirs";
  EXPECT_THAT(room_.distances(1).stations(), ElementsAre(0, 2, 4, 6, 8));
}

}  // namespace
}  // namespace raywalk
