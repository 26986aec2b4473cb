#include "core/room/connection_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ConnectionErrorMeasurement measurement(const std::string& generation, double e_connect) {
  return {.generation = generation,
          .viewpoints = 7,
          .overlap_deg = 4.0,
          .common_share = 0.75,
          .rows = {{45.0, std::nan(""), std::nan(""), 0.0},
                   {80.5, e_connect, std::nan(""), 1.0 / 3.0}}};
}

class ConnectionErrorsTest : public ::testing::Test {
 protected:
  std::string read_error() const {
    try {
      read_connection_errors(directory_.path());
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  TestDirectory directory_;
};

TEST_F(ConnectionErrorsTest, RoomWithoutMeasurementReadsAsEmpty) {
  EXPECT_TRUE(read_connection_errors(directory_.path()).empty());
}

TEST_F(ConnectionErrorsTest, IsReadAsItWasStored) {
  store_connection_errors(directory_.path(), measurement("hlf-vd", 0.1));
  const auto read = read_connection_errors(directory_.path());
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].generation, "hlf-vd");
  EXPECT_EQ(read[0].viewpoints, 7);
  EXPECT_EQ(read[0].overlap_deg, 4.0);
  EXPECT_EQ(read[0].common_share, 0.75);
  ASSERT_EQ(read[0].rows.size(), 2U);
  EXPECT_EQ(read[0].rows[0].k_deg, 45.0);
  EXPECT_TRUE(std::isnan(read[0].rows[0].e_connect));
  EXPECT_EQ(read[0].rows[1].e_connect, 0.1);
  EXPECT_EQ(read[0].rows[1].coverage, 1.0 / 3.0);
}

TEST_F(ConnectionErrorsTest, LeastErrorPrefersThePhysicalConnectionOfEquals) {
  ConnectionErrorMeasurement measured = measurement("initial", 3.0);
  measured.rows.push_back({85.0, 2.0, 2.0, 1.0});
  measured.rows.push_back({88.0, 2.0, 2.0, 1.0});
  measured.rows.push_back({90.0, 1.0, 5.0, 1.0});
  EXPECT_EQ(least_error(measured)->k_deg, 88.0);
  measured.common_share = 0.49;
  EXPECT_FALSE(least_error(measured)) << "too few corners are compared";
  measured.common_share = std::nan("");
  EXPECT_FALSE(least_error(measured)) << "how many corners are compared is not known";
  measured.common_share = 1.0;
  measured.rows.resize(2);
  EXPECT_FALSE(least_error(measured)) << "nothing could be measured";
}

TEST_F(ConnectionErrorsTest, LeastErrorsSkipUnmeasuredGenerations) {
  EXPECT_TRUE(least_errors(directory_.path()).empty());
  ConnectionErrorMeasurement unread = measurement("initial", 3.0);
  unread.rows.resize(1);
  store_connection_errors(directory_.path(), unread);
  ConnectionErrorMeasurement measured = measurement("two-sided", 3.0);
  measured.rows.push_back({85.0, 2.0, 2.0, 1.0});
  store_connection_errors(directory_.path(), measured);
  const std::vector<MeasuredConnection> least = least_errors(directory_.path());
  ASSERT_EQ(least.size(), 1U);
  EXPECT_EQ(least[0].generation, "two-sided");
  EXPECT_EQ(least[0].k_deg, 85.0);
  EXPECT_EQ(least[0].e_connect, 2.0);
}

TEST_F(ConnectionErrorsTest, AnEarlierFileWithoutTheCommonShareIsRead) {
  store_connection_errors(directory_.path(), measurement("hlf-vd", 0.1));
  std::string text = read_file(connection_errors_path(directory_.path()));
  const std::string key = "\"common_share\": 0.75,";
  text.erase(text.find(key), key.size());
  write_file_atomically(connection_errors_path(directory_.path()), text);
  EXPECT_TRUE(std::isnan(read_connection_errors(directory_.path()).at(0).common_share));
}

TEST_F(ConnectionErrorsTest, DamageIsReportedAndThenReplaced) {
  store_connection_errors(directory_.path(), measurement("hlf-vd", 1.5));
  const std::filesystem::path file = connection_errors_path(directory_.path());
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
                                 with("\"common_share\": 0.75", "\"common_share\": 1.5"),
                                 with("\"viewpoints\": 7", "\"viewpoints\": 0"),
                                 with("\"rows\"", "\"lines\"")};
  for (const std::string& text : damaged) {
    write_file_atomically(file, text);
    EXPECT_THAT(read_error(), AllOf(HasSubstr(file.string()),
                                    HasSubstr("measure again with raywalk-render connect-error")))
        << text;
  }
  store_connection_errors(directory_.path(), measurement("initial", 2.5));
  EXPECT_EQ(read_connection_errors(directory_.path()).size(), 1U);
}

}  // namespace
}  // namespace raywalk
