#include "render/validation/choose_k.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/geometry/connection_error.h"
#include "render/validation/connect_error_file.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;

class ChooseKTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  // Stores a measurement with the given errors at k = 60, 70, 80, ...
  void store(Generation generation, const std::vector<double>& errors) const {
    ConnectError measurement{.generation = generation};
    double k_deg = 60.0;
    for (const double error : errors) {
      measurement.rows.push_back({.k_deg = k_deg,
                                  .generation = generation,
                                  .e_connect = error,
                                  .e_connect_common = error,
                                  .coverage = std::isnan(error) ? 0.0 : 1.0});
      k_deg += 10.0;
    }
    store_connect_error(path_, measurement);
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(ChooseKTest, LeastMeasuredErrorWins) {
  const Room room = room_of({.width = 32});
  store(Generation::kInitial, {30.0, 20.0, 20.1, 40.0});
  const AutoK chosen = auto_k_deg(room, Generation::kInitial);
  EXPECT_EQ(chosen.k_deg, 70.0);
  EXPECT_EQ(chosen.source, "measured E_connect of initial views");
}

TEST_F(ChooseKTest, OfEqualErrorsTheMorePhysicalConnectionWins) {
  const Room room = room_of({.width = 32});
  store(Generation::kInitial, {20.0, 10.0, 10.0, 20.0});
  EXPECT_EQ(auto_k_deg(room, Generation::kInitial).k_deg, 80.0);
}

TEST_F(ChooseKTest, OwnGenerationThenTheOtherCorrectedOneThenInitialViews) {
  const Room room = room_of({.width = 32});
  store(Generation::kInitial, {1.0, 2.0, 3.0});
  EXPECT_EQ(auto_k_deg(room, Generation::kTwoSided).k_deg, 60.0);
  EXPECT_EQ(auto_k_deg(room, Generation::kHlfVd).k_deg, 60.0);
  store(Generation::kHlfVd, {2.0, 1.0, 3.0});
  EXPECT_EQ(auto_k_deg(room, Generation::kTwoSided).k_deg, 70.0);
  EXPECT_EQ(auto_k_deg(room, Generation::kHlfVd).k_deg, 70.0);
  EXPECT_EQ(auto_k_deg(room, Generation::kInitial).k_deg, 60.0);
  store(Generation::kTwoSided, {3.0, 2.0, 1.0});
  const AutoK chosen = auto_k_deg(room, Generation::kTwoSided);
  EXPECT_EQ(chosen.k_deg, 80.0);
  EXPECT_EQ(chosen.source, "measured E_connect of two-sided views");
  EXPECT_EQ(auto_k_deg(room, Generation::kHlfVd).k_deg, 70.0);
}

TEST_F(ChooseKTest, UnmeasuredRowsAreIgnored) {
  const Room room = room_of({.width = 32});
  store(Generation::kInitial, {std::nan(""), 5.0, std::nan("")});
  EXPECT_EQ(auto_k_deg(room, Generation::kInitial).k_deg, 70.0);
  store(Generation::kInitial, {std::nan("")});
  EXPECT_THAT(auto_k_deg(room, Generation::kInitial).source, HasSubstr("model"));
}

TEST_F(ChooseKTest, CorrectedMeasurementIsNotUsedForInitialViews) {
  const Room room = room_of({.width = 32});
  store(Generation::kHlfVd, {1.0, 2.0});
  EXPECT_THAT(auto_k_deg(room, Generation::kInitial).source, HasSubstr("model"));
}

TEST_F(ChooseKTest, ModelUsesTheRoomsDistances) {
  SyntheticRoomSpec spec{.side_m = 1.0, .spacing_m = 0.1, .width = 64};
  spec.scene.walls = {{-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}};
  const AutoK near = auto_k_deg(room_of(spec), Generation::kInitial);
  EXPECT_EQ(near.source, "model E_t over the room's distances");
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
  EXPECT_NEAR(near.k_deg, connection_error_curve(sampling, some_m).optimum_k_deg, 1.0);
}

TEST_F(ChooseKTest, InfinitelyFarRoomConnectsPhysically) {
  SyntheticRoomSpec spec{.width = 32};
  spec.scene.infinitely_far = true;
  EXPECT_EQ(auto_k_deg(room_of(spec), Generation::kInitial).k_deg, 90.0);
}

TEST_F(ChooseKTest, WithoutDistancesTheModelUsesThePapersDistance) {
  const AutoK chosen =
      auto_k_deg(room_of({.side_m = 2.0, .spacing_m = 0.25, .width = 32, .distances = false}),
                 Generation::kInitial);
  EXPECT_EQ(chosen.source, "model E_t at 1.5 N");
  const double d_src_m = 3.0;
  const CellSampling sampling{.side_m = 2.0, .step_m = 0.25};
  EXPECT_EQ(chosen.k_deg, connection_error_curve(sampling, {&d_src_m, 1}).optimum_k_deg);
}

TEST_F(ChooseKTest, RoomWithoutCellsHasNoConnection) {
  const AutoK chosen = auto_k_deg(room_of({.cells_z = 0, .width = 32}), Generation::kHlfVd);
  EXPECT_EQ(chosen.source, "the room has no connections");
  EXPECT_EQ(chosen.k_deg, 90.0);
}

TEST_F(ChooseKTest, RequirementsPrecedeTheModelAndFollowTheMeasurement) {
  const Room room = room_of({.width = 32});
  RoomRequirements required;
  required.connection.model_k_deg = 61.0;
  AutoK chosen = auto_k_deg(room, Generation::kHlfVd, &required);
  EXPECT_EQ(chosen.k_deg, 61.0);
  EXPECT_EQ(chosen.source, "model E_t in require.json");
  required.connection.measured = {{"initial", 62.0, 10.0}, {"two-sided", 63.0, 1.0}};
  chosen = auto_k_deg(room, Generation::kHlfVd, &required);
  EXPECT_EQ(chosen.k_deg, 63.0);
  EXPECT_EQ(chosen.source, "measured E_connect of two-sided views in require.json");
  EXPECT_EQ(auto_k_deg(room, Generation::kInitial, &required).k_deg, 62.0);
  store(Generation::kInitial, {3.0, 2.0, 1.0});
  EXPECT_EQ(auto_k_deg(room, Generation::kInitial, &required).k_deg, 80.0);
}

TEST_F(ChooseKTest, RequirementsWithoutConnectionFallBackToTheModel) {
  const RoomRequirements required;
  EXPECT_EQ(auto_k_deg(room_of({.width = 32}), Generation::kHlfVd, &required).source,
            "model E_t over the room's distances");
}

TEST_F(ChooseKTest, DamagedMeasurementIsAnError) {
  const Room room = room_of({.width = 32});
  write_file_atomically(connection_errors_path(path_), "damaged");
  EXPECT_THROW(auto_k_deg(room, Generation::kInitial), Error);
}

}  // namespace
}  // namespace raywalk::render
