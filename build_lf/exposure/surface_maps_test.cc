#include "build_lf/exposure/surface_maps.h"

#include <gmock/gmock.h>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/exposure/patch_ratios.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

SyntheticRoomSpec line_with_maps(int distance_width) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.5;
  spec.width = 512;
  spec.distance_width = distance_width;
  spec.distance_every = 2;
  return spec;
}

class SurfaceMapsTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room");
    return Room::open(directory_ / "room");
  }
  TestDirectory directory_;
};

TEST_F(SurfaceMapsTest, AreThoseOfTheRoomReduced) {
  const SyntheticRoomSpec spec = line_with_maps(512);
  const Room room = room_of(spec);
  const SurfaceMaps maps = surface_maps_of(room);
  EXPECT_EQ(maps.size, (PanoramaSize{kSurfaceWidth, kSurfaceWidth / 2}));
  ASSERT_THAT(maps.stations, ElementsAre(StationIndex{0, 0}, StationIndex{0, 2}));
  const InverseDistanceMap map = maps.read({0, 2});
  const InverseDistanceMap truth = true_map(spec.scene, map.position_m, maps.size);
  EXPECT_EQ(map.position_m, room.grid().lines[0].stations[2].position_m);
  EXPECT_GT(share_within(map, truth, 0.01), 0.98);
}

TEST_F(SurfaceMapsTest, AreNotWiderThanStored) {
  EXPECT_EQ(surface_maps_of(room_of(line_with_maps(64))).size, (PanoramaSize{64, 32}));
}

TEST_F(SurfaceMapsTest, AreUnknownWhereNotReliable) {
  SyntheticRoomSpec spec = line_with_maps(512);
  spec.stored_confidence = [](int u, int) { return u < 256 ? kMinConfidence - 1 : kMinConfidence; };
  const Room room = room_of(spec);
  const SurfaceMaps maps = surface_maps_of(room);
  const InverseDistanceMap map = maps.read({0, 0});
  for (int theta = 0; theta < maps.size.width; ++theta) {
    EXPECT_EQ(map.confidence[pixel_index(theta, 20, maps.size)] > 0, theta >= 128) << theta;
  }
}

TEST_F(SurfaceMapsTest, AreNoneInARoomWithoutDistances) {
  SyntheticRoomSpec spec = line_with_maps(64);
  spec.distances = false;
  EXPECT_THAT(surface_maps_of(room_of(spec)).stations, IsEmpty());
}

}  // namespace
}  // namespace raywalk::build_lf
