#include "core/session/checked_row.h"

#include <gmock/gmock.h>

#include <functional>

#include "core/base/error.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CheckedRowTest : public testing::Test {
 protected:
  // The message of reading the only value of "SELECT <value> AS measured_mm"; empty if it is right.
  std::string error(const std::string& value, const std::function<void(const CheckedRow&)>& read) {
    CheckedRow row(&database_, "SELECT " + value + " AS measured_mm", "hall", "a station");
    EXPECT_TRUE(row.step());
    row.call("station x0_001");
    try {
      read(row);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  static void real(const CheckedRow& row) { row.real(0, -10.0, 10.0); }
  static void integer(const CheckedRow& row) { row.integer(0, 1, 5); }
  static void name(const CheckedRow& row) { row.name(0); }
  static void utc_us(const CheckedRow& row) { row.utc_us(0); }

  SqliteConnection database_{":memory:", SqliteAccess::kReadWrite};
};

TEST_F(CheckedRowTest, NamesFileColumnRowAndWhatItMustBe) {
  EXPECT_THAT(error("NULL", real),
              AllOf(HasSubstr("hall/session.db: damaged: measured_mm of station x0_001 is NULL; it "
                              "must be a number from -10 to 10"),
                    HasSubstr("restore")));
}

TEST_F(CheckedRowTest, RealsAreFiniteAndInRange) {
  for (const char* right : {"-10.0", "0.0", "10.0"}) EXPECT_EQ(error(right, real), "") << right;
  for (const char* wrong : {"10.1", "1e308", "9e999", "-9e999", "'1.0'", "x'00'", "NULL"}) {
    EXPECT_THAT(error(wrong, real), HasSubstr("damaged")) << wrong;
  }
}

TEST_F(CheckedRowTest, IntegersAreWholeAndInRange) {
  for (const char* right : {"1", "5"}) EXPECT_EQ(error(right, integer), "") << right;
  for (const char* wrong : {"0", "6", "-1", "2.0", "9223372036854775807", "'2'", "NULL"}) {
    EXPECT_THAT(error(wrong, integer), HasSubstr("a whole number from 1 to 5")) << wrong;
  }
}

TEST_F(CheckedRowTest, NamesAreTextWithoutControlCharacters) {
  EXPECT_EQ(error("'x0_001'", name), "");
  for (const char* wrong : {"''", "'a' || char(10)", "char(27)", "1", "x'61'", "NULL"}) {
    EXPECT_THAT(error(wrong, name), HasSubstr("damaged")) << wrong;
  }
}

TEST_F(CheckedRowTest, TimesFitTheClock) {
  EXPECT_EQ(error("1767225600000000", utc_us), "");
  EXPECT_THAT(error("9223372036854775807", utc_us), HasSubstr("damaged"));
  EXPECT_THAT(error("-1", utc_us), HasSubstr("damaged"));
}

}  // namespace
}  // namespace raywalk
