#include "core/room/choose_k.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

// The given errors at k = 60, 70, 80, ..., all over the same corners.
ConnectionErrorMeasurement measured(const std::string& generation,
                                    const std::vector<double>& errors) {
  ConnectionErrorMeasurement measurement{
      .generation = generation, .viewpoints = 9, .overlap_deg = 5.0, .common_share = 1.0};
  for (const double error : errors) {
    measurement.rows.push_back({.k_deg = 60.0 + 10.0 * static_cast<double>(measurement.rows.size()),
                                .e_connect = error,
                                .e_connect_common = error,
                                .coverage = 1.0});
  }
  return measurement;
}

TEST(ChooseK, LeastMeasuredErrorWins) {
  const std::vector all{measured("initial", {30.0, 20.0, 20.1, 40.0})};
  const ChosenK chosen = choose_k(all, "initial");
  EXPECT_EQ(chosen.k_deg, 70.0);
  EXPECT_EQ(chosen.source, "measured E_connect of initial views");
}

// k = 60 has the least error of all, but over half as many corners as k = 80.
TEST(ChooseK, ComparesOnlyTheCornersReadableAtEveryK) {
  ConnectionErrorMeasurement measurement = measured("initial", {1.0, 20.0, 30.0});
  measurement.common_share = 0.5;
  measurement.rows[0].coverage = 0.5;
  measurement.rows[0].e_connect_common = 25.0;
  measurement.rows[1].e_connect_common = 24.0;
  measurement.rows[2].e_connect_common = 12.0;
  EXPECT_EQ(choose_k(std::vector{measurement}, "initial").k_deg, 80.0);
}

TEST(ChooseK, WithTooFewCommonCornersItSaysSoAndTakesNinety) {
  ConnectionErrorMeasurement measurement = measured("initial", {1.0, 20.0, 30.0});
  measurement.common_share = 0.31;
  ChosenK chosen = choose_k(std::vector{measurement}, "initial");
  EXPECT_EQ(chosen.k_deg, 90.0);
  EXPECT_EQ(chosen.source,
            "connect-error could compare only 31 % of the corners at every k; 90 is best on the "
            "rooms measured so far");
  measurement.common_share = std::nan("");
  chosen = choose_k(std::vector{measurement}, "initial");
  EXPECT_EQ(chosen.k_deg, 90.0);
  EXPECT_THAT(chosen.source, HasSubstr("measure again"));
  chosen = choose_k(std::vector{measured("initial", {1.0})}, "initial");
  EXPECT_EQ(chosen.k_deg, 90.0);
  EXPECT_THAT(chosen.source, HasSubstr("only one k"));
}

TEST(ChooseK, WithoutAMeasurementItTakesNinety) {
  EXPECT_EQ(choose_k(std::vector<ConnectionErrorMeasurement>{}, "hlf-vd").k_deg, 90.0);
  EXPECT_EQ(choose_k(std::vector<ConnectionErrorMeasurement>{}, "hlf-vd").source,
            "not measured on this room; 90 is best on the rooms measured so far");
}

TEST(ChooseK, OfEqualErrorsTheMorePhysicalConnectionWins) {
  EXPECT_EQ(choose_k(std::vector{measured("initial", {20.0, 10.0, 10.0, 20.0})}, "initial").k_deg,
            80.0);
}

TEST(ChooseK, OwnGenerationThenTheOtherCorrectedOneThenInitialViews) {
  std::vector all{measured("initial", {1.0, 2.0, 3.0})};
  EXPECT_EQ(choose_k(all, "two-sided").k_deg, 60.0);
  EXPECT_EQ(choose_k(all, "hlf-vd").k_deg, 60.0);
  all.push_back(measured("hlf-vd", {2.0, 1.0, 3.0}));
  EXPECT_EQ(choose_k(all, "two-sided").k_deg, 70.0);
  EXPECT_EQ(choose_k(all, "hlf-vd").k_deg, 70.0);
  EXPECT_EQ(choose_k(all, "initial").k_deg, 60.0);
  all.push_back(measured("two-sided", {3.0, 2.0, 1.0}));
  const ChosenK chosen = choose_k(all, "two-sided");
  EXPECT_EQ(chosen.k_deg, 80.0);
  EXPECT_EQ(chosen.source, "measured E_connect of two-sided views");
  EXPECT_EQ(choose_k(all, "hlf-vd").k_deg, 70.0);
}

TEST(ChooseK, CorrectedMeasurementIsNotUsedForInitialViews) {
  const std::vector all{measured("hlf-vd", {1.0, 2.0})};
  EXPECT_THAT(choose_k(all, "initial").source, HasSubstr("not measured"));
}

class RoomsKTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(RoomsKTest, IsThatOfTheStoredMeasurement) {
  const Room room = room_of({.width = 32});
  EXPECT_EQ(choose_k(room, "initial").k_deg, 90.0);
  store_connection_errors(path_, measured("initial", {3.0, 2.0, 4.0}));
  EXPECT_EQ(choose_k(room, "initial").k_deg, 70.0);
  EXPECT_EQ(choose_k(room, "hlf-vd").k_deg, 70.0);
}

TEST_F(RoomsKTest, RoomWithoutCellsHasNoConnection) {
  const ChosenK chosen = choose_k(room_of({.cells_z = 0, .width = 32}), "hlf-vd");
  EXPECT_EQ(chosen.source, "the room has no connections");
  EXPECT_EQ(chosen.k_deg, 90.0);
}

TEST_F(RoomsKTest, DamagedMeasurementIsAnError) {
  const Room room = room_of({.width = 32});
  write_file_atomically(connection_errors_path(path_), "damaged");
  EXPECT_THROW(choose_k(room, "initial"), Error);
}

}  // namespace
}  // namespace raywalk
