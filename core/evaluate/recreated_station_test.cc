#include "core/evaluate/recreated_station.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/evaluate/metrics.h"
#include "core/files/test_directory.h"
#include "core/room/kept_stations.h"
#include "tests/synthetic_room/synthetic_room.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
namespace {

// The station to re-create and how many stations on both sides of it are left out too.
struct Gap {
  int station = 8;
  int others = 1;
};

class RecreatedStationTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec, const std::string& name = "room.lf") const {
    write_synthetic_room(spec, directory_ / name);
    return Room::open(directory_ / name);
  }
  // A line of 17 stations over 2 m.
  static SyntheticRoomSpec long_line() {
    return {.cells_z = 0, .side_m = 2.0, .spacing_m = 0.125, .width = 256};
  }
  static Room without(const Room& room, const Gap& gap) {
    std::vector<std::vector<int>> left_out(room.grid().lines.size());
    for (int i = gap.station - gap.others; i <= gap.station + gap.others; ++i) {
      left_out[0].push_back(i);
    }
    return room.subset(stations_except(room.grid(), left_out));
  }
  static RecreationScore score(const Room& room, const Room& kept, const Room& distances,
                               int station, double tolerance_px = 0.5) {
    return StationRecreation(room, distances, tolerance_px).score({0, station}, kept);
  }
  static RecreationScore score(const Room& room, const Gap& gap, double tolerance_px = 0.5) {
    return score(room, without(room, gap), room, gap.station, tolerance_px);
  }

  TestDirectory directory_;
};

TEST_F(RecreatedStationTest, DistancesRemoveGhosts) {
  const RecreationScore of = score(room_of(long_line()), Gap{});
  EXPECT_GT(of.psnr_with_distances_db, 38.0);
  EXPECT_LT(of.psnr_without_depth_db, 28.0);
  EXPECT_LT(of.hidden_share, 1e-3) << "nothing hides anything in an empty room";
}

TEST_F(RecreatedStationTest, WrongDistancesAreFound) {
  SyntheticRoomSpec spec = long_line();
  const Gap gap{.others = 3};
  const RecreationScore right = score(room_of(spec, "right.lf"), gap);
  spec.stored_distance = [](int, int, double exact_m) {
    return static_cast<float>(1.25 * exact_m);
  };
  const RecreationScore wrong = score(room_of(spec, "wrong.lf"), gap);
  EXPECT_LT(wrong.psnr_with_distances_db, right.psnr_with_distances_db - 8.0);
  EXPECT_EQ(wrong.psnr_without_depth_db, right.psnr_without_depth_db);
}

TEST_F(RecreatedStationTest, OwnMapOfAStationLeftOutIsNotUsed) {
  SyntheticRoomSpec spec = long_line();
  const RecreationScore with_all = score(room_of(spec), Gap{});
  // Only the map of the station left out is wrong; maps are made one after the other.
  spec.stored_distance = [pixel = 0](int, int, double exact_m) mutable {
    const int map = pixel++ / (256 * 128);
    return map == 8 ? 0.3f : static_cast<float>(exact_m);
  };
  const Room own_wrong = room_of(spec, "own_wrong.lf");
  ASSERT_EQ(own_wrong.distances(0).distance_column(8, 0)[0], 0.3f);
  EXPECT_EQ(score(own_wrong, Gap{}).psnr_with_distances_db, with_all.psnr_with_distances_db);
}

TEST_F(RecreatedStationTest, WithoutOtherMapsEverythingIsInfinitelyFar) {
  SyntheticRoomSpec spec = long_line();
  spec.distance_every = 1000;
  const RecreationScore of = score(room_of(spec), {.station = 8});
  const Room bare =
      room_of(spec, "bare.lf").subset({{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}});
  const RecreationScore without_maps = score(bare, {.station = 7});
  EXPECT_EQ(without_maps.psnr_with_distances_db, without_maps.psnr_without_depth_db);
  EXPECT_GT(of.psnr_with_distances_db, without_maps.psnr_with_distances_db + 5.0);
}

TEST_F(RecreatedStationTest, TheStationsOwnPositionCounts) {
  SyntheticRoomSpec spec = long_line();
  spec.off_line = [](const std::string&, int station) {
    return station == 8 ? OffLine{.across_m = 0.03, .up_m = -0.02} : OffLine{};
  };
  EXPECT_GT(score(room_of(spec), Gap{}).psnr_with_distances_db, 38.0);
}

TEST_F(RecreatedStationTest, OccludedPointsAreReadFromTheOtherNeighbour) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.obstacle = SceneBox{{-0.15, -0.5, 0.5}, {0.15, 0.5, 0.8}};
  spec.scene.texture_wavelength_m = 0.7;
  const RecreationScore of = score(room_of(spec), {.others = 3});
  EXPECT_GT(of.psnr_with_distances_db, 27.0);
  EXPECT_GT(of.psnr_with_distances_db, of.psnr_without_depth_db + 7.0);
}

// What a neighbour sees is gathered from the maps around it, those in the gap too.
TEST_F(RecreatedStationTest, NeighboursNeedNoMapsOfTheirOwn) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.obstacle = SceneBox{{-0.15, -0.5, 0.5}, {0.15, 0.5, 0.8}};
  spec.scene.texture_wavelength_m = 0.7;
  const RecreationScore mapped = score(room_of(spec), {.station = 7, .others = 2});
  spec.distance_every = 3;  // station 6 and 9, but neither 4 nor 10
  const Room room = room_of(spec, "some.lf");
  const RecreationScore some = score(room, {.station = 7, .others = 2});
  EXPECT_GT(some.psnr_with_distances_db, mapped.psnr_with_distances_db - 1.0);
  EXPECT_GT(some.psnr_with_distances_db, some.psnr_without_depth_db + 7.0);
}

// Two pillars beside each other: the station sees the wall between them, its neighbours do not. A
// scene has one obstacle, so that the second pillar is in the distance maps only.
TEST_F(RecreatedStationTest, WhatNeitherNeighbourSeesIsHidden) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.obstacle = SceneBox{{-0.6, -0.6, 0.3}, {-0.1, 0.6, 0.4}};
  SyntheticScene second = spec.scene;
  second.obstacle = SceneBox{{0.1, -0.6, 0.3}, {0.6, 0.6, 0.4}};
  const auto distance_m = [&](const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
    return std::min(distance_at(spec.scene, from_m, direction),
                    distance_at(second, from_m, direction));
  };
  const std::vector<Station> stations = synthetic_grid(spec).lines[0].stations;
  const PanoramaSize size{256, 128};
  spec.stored_distance = [&, pixel = 0](int u, int v, double) mutable {
    const auto map = static_cast<size_t>(pixel++ / (256 * 128));
    const PixelPosition at{double(u), double(v)};
    return static_cast<float>(
        distance_m(stations[map].position_m, direction_from_angles(angles_from_pixel(at, size))));
  };
  // Whether a station sees a point.
  const auto sees = [&](size_t station, const Eigen::Vector3d& point_m) {
    const Eigen::Vector3d to_m = point_m - stations[station].position_m;
    return distance_m(stations[station].position_m, to_m.normalized()) > 0.999 * to_m.norm();
  };
  double hidden = 0.0, all = 0.0;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
      const Eigen::Vector3d direction = direction_from_angles(angles);
      const Eigen::Vector3d& from_m = stations[8].position_m;
      const Eigen::Vector3d point_m = from_m + distance_m(from_m, direction) * direction;
      all += std::cos(angles.phi_rad);
      if (!sees(4, point_m) && !sees(12, point_m)) hidden += std::cos(angles.phi_rad);
    }
  }
  EXPECT_GT(hidden / all, 0.02);
  EXPECT_NEAR(score(room_of(spec), {.others = 3}).hidden_share, hidden / all, 0.3 * hidden / all);
}

TEST_F(RecreatedStationTest, TolerancePsnrIsThatOfADisplacedPicture) {
  SyntheticRoomSpec flat = long_line();
  flat.scene.contrast = 0.0;
  EXPECT_EQ(score(room_of(flat, "flat.lf"), Gap{}).psnr_of_tolerance_db, kMaxPsnrDb)
      << "of a blank wall any displacement is right";
  const Room room = room_of(long_line());
  // Twice the displacement is four times the squared error where texture is coarse.
  EXPECT_NEAR(
      score(room, Gap{}, 1.0).psnr_of_tolerance_db - score(room, Gap{}, 2.0).psnr_of_tolerance_db,
      6.0, 0.7);
}

TEST_F(RecreatedStationTest, MaskedPixelsAreNotCompared) {
  SyntheticRoomSpec spec = long_line();
  const RecreationScore clean = score(room_of(spec), Gap{});
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return direction.y() < -0.8;
      }};
  const RecreationScore masked = score(room_of(spec), Gap{});
  EXPECT_NEAR(masked.psnr_with_distances_db, clean.psnr_with_distances_db, 1.0);
  EXPECT_NEAR(masked.psnr_without_depth_db, clean.psnr_without_depth_db, 2.0);
  spec.companion->color = {0, 255, 0};
  const RecreationScore recoloured = score(room_of(spec), Gap{});
  EXPECT_EQ(recoloured.psnr_with_distances_db, masked.psnr_with_distances_db);
  // Half a pixel beside a pixel may be masked.
  EXPECT_NEAR(recoloured.psnr_of_tolerance_db, masked.psnr_of_tolerance_db, 1.0);
  spec.companion->masked = false;
  EXPECT_LT(score(room_of(spec), Gap{}).psnr_with_distances_db,
            masked.psnr_with_distances_db - 5.0);
}

TEST_F(RecreatedStationTest, WhatOneNeighbourMasksIsReadFromTheOther) {
  SyntheticRoomSpec spec = long_line();
  const RecreationScore clean = score(room_of(spec), Gap{});
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int station, const Eigen::Vector3d& d) {
        return station == 6 && d.y() < 0.0;
      }};
  const RecreationScore of = score(room_of(spec), Gap{});
  EXPECT_GT(of.psnr_with_distances_db, clean.psnr_with_distances_db - 3.0);
  EXPECT_LT(of.hidden_share, 0.02);
}

TEST_F(RecreatedStationTest, FullyMaskedRoomIsNotCompared) {
  SyntheticRoomSpec spec = long_line();
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d&) { return true; }};
  const RecreationScore of = score(room_of(spec), Gap{});
  EXPECT_EQ(of.hidden_share, 1.0);
  EXPECT_EQ(of.psnr_with_distances_db, kMaxPsnrDb);
}

TEST_F(RecreatedStationTest, WidePanoramasAreSampledToTheSameResult) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.texture_wavelength_m = 0.7;
  const RecreationScore narrow = score(room_of(spec, "narrow.lf"), {.others = 3});
  spec.width = 1024;  // every second pixel is compared
  spec.distance_width = 256;
  const RecreationScore wide = score(room_of(spec, "wide.lf"), {.others = 3}, 2.0);
  EXPECT_NEAR(wide.psnr_without_depth_db, narrow.psnr_without_depth_db, 0.5);
  EXPECT_NEAR(wide.psnr_of_tolerance_db, narrow.psnr_of_tolerance_db, 1.5);
}

}  // namespace
}  // namespace raywalk
