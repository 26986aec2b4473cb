#include "core/room/connection_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

class ConnectionModelTest : public ::testing::Test {
 protected:
  ConnectionModel model_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room.lf");
    return connection_model(Room::open(directory_ / "room.lf"));
  }
  TestDirectory directory_;
};

TEST_F(ConnectionModelTest, UsesTheRoomsDistances) {
  SyntheticRoomSpec spec{.side_m = 1.0, .spacing_m = 0.1, .width = 64};
  spec.scene.walls = {{-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}};
  const ConnectionModel near = model_of(spec);
  EXPECT_TRUE(near.from_distances);
  // Independently: rays of the sphere, equally dense, from the middle of a line.
  std::vector<double> distances_m;
  for (int latitude_deg = -85; latitude_deg <= 85; latitude_deg += 10) {
    const double phi_rad = radians_from_degrees(latitude_deg);
    const int count = static_cast<int>(std::lround(36.0 * std::cos(phi_rad)));
    for (int i = 0; i < count; ++i) {
      const SphereAngles angles{kTwoPi * i / count - kPi + 0.1, phi_rad};
      distances_m.push_back(
          distance_at(spec.scene, {0.0, 0.0, 0.5}, direction_from_angles(angles)));
    }
  }
  std::ranges::sort(distances_m);
  std::vector<double> some_m;
  for (size_t i = 1; i < 14; i += 2) some_m.push_back(distances_m[i * distances_m.size() / 14]);
  const CellSampling sampling{.side_m = 1.0, .step_m = 0.1};
  EXPECT_NEAR(near.curve.optimum_k_deg, connection_error_curve(sampling, some_m).optimum_k_deg, 1);
}

TEST_F(ConnectionModelTest, InfinitelyFarRoomConnectsPhysically) {
  SyntheticRoomSpec spec{.width = 32};
  spec.scene.infinitely_far = true;
  EXPECT_EQ(model_of(spec).curve.optimum_k_deg, 90);
}

TEST_F(ConnectionModelTest, WithoutDistancesThePapersDistanceIsUsed) {
  const ConnectionModel model =
      model_of({.side_m = 2.0, .spacing_m = 0.25, .width = 32, .distances = false});
  EXPECT_FALSE(model.from_distances);
  const double d_src_m = 3.0;
  const CellSampling sampling{.side_m = 2.0, .step_m = 0.25};
  EXPECT_EQ(model.curve.optimum_k_deg,
            connection_error_curve(sampling, {&d_src_m, 1}).optimum_k_deg);
}

}  // namespace
}  // namespace raywalk
