#include "core/judge/validation/connect_error_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ConnectError measurement(Generation generation, double e_connect) {
  ConnectError result{.generation = generation,
                      .options = {.viewpoints = 7, .overlap_deg = 4.0, .k_list_deg = {45.0, 80.5}},
                      .common_share = 0.25};
  result.rows = {{.connection = "lfu",
                  .k_deg = 45.0,
                  .generation = generation,
                  .e_connect = std::nan(""),
                  .e_connect_common = std::nan(""),
                  .coverage = 0.0},
                 {.connection = "hybrid",
                  .k_deg = 80.5,
                  .generation = generation,
                  .e_connect = e_connect,
                  .e_connect_common = std::nan(""),
                  .coverage = 1.0 / 3.0}};
  return result;
}

class ConnectErrorFileTest : public ::testing::Test {
 protected:
  TestDirectory directory_;
};

TEST_F(ConnectErrorFileTest, RoomWithoutMeasurementReadsAsEmpty) {
  EXPECT_TRUE(read_connect_error(directory_.path()).empty());
}

TEST_F(ConnectErrorFileTest, IsReadAsItWasStored) {
  ConnectError stored = measurement(Generation::kHlfVd, 0.1);
  stored.distances = "estimated by sweep";
  store_connect_error(directory_.path(), stored);
  const std::vector<ConnectError> read = read_connect_error(directory_.path());
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].generation, Generation::kHlfVd);
  EXPECT_EQ(read[0].distances, "estimated by sweep");
  EXPECT_EQ(read[0].options.viewpoints, 7);
  EXPECT_EQ(read[0].options.overlap_deg, 4.0);
  EXPECT_EQ(read[0].common_share, 0.25);
  EXPECT_THAT(read[0].options.k_list_deg, ::testing::ElementsAre(45.0, 80.5));
  ASSERT_EQ(read[0].rows.size(), 2U);
  EXPECT_EQ(read[0].rows[0].connection, "lfu");
  EXPECT_TRUE(std::isnan(read[0].rows[0].e_connect));
  EXPECT_EQ(read[0].rows[1].generation, Generation::kHlfVd);
  EXPECT_EQ(read[0].rows[1].e_connect, 0.1);
  EXPECT_TRUE(std::isnan(read[0].rows[1].e_connect_common));
  EXPECT_EQ(read[0].rows[1].coverage, 1.0 / 3.0);
}

TEST_F(ConnectErrorFileTest, NewMeasurementReplacesItsGenerationOnly) {
  store_connect_error(directory_.path(), measurement(Generation::kInitial, 1.0));
  store_connect_error(directory_.path(), measurement(Generation::kHlfVd, 2.0));
  store_connect_error(directory_.path(), measurement(Generation::kInitial, 3.0));
  std::vector<ConnectError> read = read_connect_error(directory_.path());
  ASSERT_EQ(read.size(), 2U);
  std::ranges::sort(read, {}, &ConnectError::generation);
  EXPECT_EQ(read[0].rows[1].e_connect, 3.0);
  EXPECT_EQ(read[1].rows[1].e_connect, 2.0);
}

TEST_F(ConnectErrorFileTest, MeasurementsAreStoredAndPrinted) {
  const std::filesystem::path path = directory_ / "room.lf";
  write_synthetic_room({.overhang_m = 0.25, .width = 64}, path);
  const Room room = Room::open(path);
  std::ostringstream table;
  write_connect_error(room, std::array{Generation::kInitial, Generation::kHlfVd}, {.viewpoints = 2},
                      table);
  EXPECT_THAT(table.str(), AllOf(HasSubstr("initial views"), HasSubstr("hlf-vd views")));
  EXPECT_EQ(read_connect_error(path).size(), 2U);
}

// 130 is no width of a view.
TEST_F(ConnectErrorFileTest, PanoramasOfAnyEvenWidthAreMeasured) {
  const auto initial_error = [&](int width) {
    const std::filesystem::path path = directory_ / std::to_string(width);
    write_synthetic_room({.overhang_m = 0.25, .width = width}, path);
    const Room room = Room::open(path);
    std::ostringstream table;
    write_connect_error(room, std::array{Generation::kInitial, Generation::kHlfVd},
                        {.viewpoints = 2}, table);
    return read_connect_error(path)[0].rows.back().e_connect;
  };
  const double exact = initial_error(128);
  EXPECT_NEAR(initial_error(130), exact, 0.2 * exact);
}

TEST_F(ConnectErrorFileTest, RoomThatCannotBeWrittenIsRefused) {
  const std::filesystem::path path = directory_ / "room.lf";
  write_synthetic_room({.overhang_m = 0.25, .width = 64, .distances = false}, path);
  const Room room = Room::open(path);
  std::filesystem::create_directory(connection_errors_path(path));  // in the way, for root too
  std::ostringstream table;
  EXPECT_THROW(write_connect_error(room, std::array{Generation::kInitial}, {}, table), Error);
  EXPECT_EQ(table.str(), "");
}

}  // namespace
}  // namespace raywalk
