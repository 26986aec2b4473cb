#include "render/validation/connect_error_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ConnectError measurement(Generation generation, double e_connect) {
  ConnectError result{.generation = generation,
                      .options = {.viewpoints = 7, .overlap_deg = 4.0, .k_list_deg = {45.0, 80.5}}};
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
  std::string read_error() const {
    try {
      read_connect_error(directory_.path());
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  TestDirectory directory_;
};

TEST_F(ConnectErrorFileTest, RoomWithoutMeasurementReadsAsEmpty) {
  EXPECT_TRUE(read_connect_error(directory_.path()).empty());
}

TEST_F(ConnectErrorFileTest, IsReadAsItWasStored) {
  store_connect_error(directory_.path(), measurement(Generation::kHlfVd, 0.1));
  const std::vector<ConnectError> read = read_connect_error(directory_.path());
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].generation, Generation::kHlfVd);
  EXPECT_EQ(read[0].options.viewpoints, 7);
  EXPECT_EQ(read[0].options.overlap_deg, 4.0);
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

TEST_F(ConnectErrorFileTest, DamageIsNamedWithItsRemedyAndThenReplaced) {
  store_connect_error(directory_.path(), measurement(Generation::kHlfVd, 1.5));
  const std::filesystem::path file = connect_error_path(directory_.path());
  const std::string whole = read_file(file);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::string damaged[] = {"",
                                 "[]",
                                 "null",
                                 "{}",
                                 whole.substr(0, whole.size() / 2),
                                 with("\"format_version\": 1", "\"format_version\": 2"),
                                 with("\"format_version\": 1", "\"format_version\": \"1\""),
                                 with("hlf-vd", "other"),
                                 with("\"hlf-vd\"", "7"),
                                 with("80.5", "90.5"),
                                 with("80.5", "null"),
                                 with("1.5", "-1.5"),
                                 with("1.5", "65026"),
                                 with("1.5", "\"low\""),
                                 with("1.5", "null"),
                                 with("0.3333", "1.3333"),
                                 with("\"viewpoints\": 7", "\"viewpoints\": 0"),
                                 with("\"rows\"", "\"lines\"")};
  for (const std::string& text : damaged) {
    write_file_atomically(file, text);
    EXPECT_THAT(read_error(), AllOf(HasSubstr(file.string()),
                                    HasSubstr("measure again with raywalk-render connect-error")))
        << text;
  }
  store_connect_error(directory_.path(), measurement(Generation::kInitial, 2.5));
  EXPECT_EQ(read_connect_error(directory_.path()).size(), 1U);
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

TEST_F(ConnectErrorFileTest, RoomThatCannotBeWrittenIsRefused) {
  const std::filesystem::path path = directory_ / "room.lf";
  write_synthetic_room({.overhang_m = 0.25, .width = 64, .distances = false}, path);
  const Room room = Room::open(path);
  std::filesystem::create_directory(connect_error_path(path));  // in the way, for root too
  std::ostringstream table;
  EXPECT_THROW(write_connect_error(room, std::array{Generation::kInitial}, {}, table), Error);
  EXPECT_EQ(table.str(), "");
}

}  // namespace
}  // namespace raywalk
