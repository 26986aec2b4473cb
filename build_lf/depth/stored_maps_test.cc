#include <gmock/gmock.h>

#include <fstream>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/pack/station_data.h"
#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
namespace fs = std::filesystem;

class StoredMapsTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec tiny = room_of_scale(1.0);
    tiny.width = 32;
    return tiny;
  }
  // Line z0 gets no maps.
  static DepthPlan plan_without_z0(const Room& room) {
    DepthPlan plan = plan_depth(room, {.every = 8});
    std::erase_if(plan.maps, [](const SweepReference& map) { return map.station.line == 2; });
    return plan;
  }
  void store_maps(PartialMaps* partial) const {
    for (const SweepReference& reference : plan_.maps) {
      InverseDistanceMap map = true_map(spec().scene, reference.position_m, plan_.size);
      map.station = reference.station;
      map.omega[3] = 0.0f;
      map.confidence[5] = static_cast<std::uint8_t>(10 * reference.station.station);
      partial->store(kFinalStage, map);
    }
  }

  DepthTestRoom room_{spec()};
  DepthPlan plan_ = plan_without_z0(room_.room());
  LineSearch no_contradictions_ = [](int) { return Contradictions(); };
};

TEST_F(StoredMapsTest, AreReadBackAsTheRoomsDistances) {
  PartialMaps partial(room_.room().directory(), "inputs");
  store_maps(&partial);
  write_volumes(room_.room(), DepthMethod::kSweep, plan_, partial, {0, 4}, no_contradictions_);
  partial.complete();
  use_distances(room_.room().directory(), DistanceKind::kEstimated);
  const Room room = Room::open(room_.room().directory());
  EXPECT_EQ(room.distances(2).maps(), 0);
  const DistanceVolume& distances = room.distances(0);
  EXPECT_THAT(distances.stations(), ElementsAre(0, 8, 16));
  EXPECT_EQ(distances.size(), plan_.size);
  EXPECT_FALSE(distances.given());
  const InverseDistanceMap truth =
      true_map(spec().scene, room.grid().lines[0].stations[8].position_m, plan_.size);
  const StationDistances stored = stored_distances(distances, 1);
  ASSERT_EQ(stored.distance_m.size(), truth.omega.size());
  for (size_t pixel = 0; pixel < truth.omega.size(); ++pixel) {
    const float omega = pixel == 3 ? 0.0f : truth.omega[pixel];
    ASSERT_EQ(stored.distance_m[pixel], 1.0f / omega);
  }
  EXPECT_EQ(stored.confidence[5], 80);
  EXPECT_EQ(stored.confidence[6], 255);
}

TEST_F(StoredMapsTest, DamagedMapIsNamedAndItsLineNotWritten) {
  PartialMaps partial(room_.room().directory(), "inputs");
  store_maps(&partial);
  for (const auto& entry : fs::directory_iterator(partial.volumes().parent_path())) {
    if (entry.path().filename() == "final-0-8.map") std::ofstream(entry.path()) << "damaged";
  }
  EXPECT_THAT(
      [&] {
        write_volumes(room_.room(), DepthMethod::kSweep, plan_, partial, {0, 4},
                      no_contradictions_);
      },
      ThrowsMessage<Error>(HasSubstr("run the command again")));
  EXPECT_TRUE(fs::is_empty(partial.volumes()));
}

}  // namespace
}  // namespace raywalk::build_lf
