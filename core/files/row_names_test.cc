#include "core/files/row_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

CsvTable table_of(const std::string& rows) {
  return CsvTable::parse("name,x\n" + rows, "path.csv", {"name", "x"}, {});
}

TEST(RowNamesTest, ComeInTheOrderOfTheRows) {
  EXPECT_THAT(file_names_of_rows(table_of("b,1\na,2\n" + std::string(200, 'c') + ",3\n"), "name"),
              ElementsAre("b", "a", std::string(200, 'c')));
  EXPECT_THAT(file_names_of_rows(table_of(""), "name"), ElementsAre());
}

TEST(RowNamesTest, InvalidAndDuplicateNamesAreRejected) {
  for (const std::string& name :
       {std::string("../a"), std::string("/a"), std::string(".a"), std::string("\"\""),
        std::string("\"a,b\""), std::string("\"a\"\"b\""), std::string("\"a\nb\""),
        std::string("\"a\rb\""), std::string(201, 'c')}) {
    EXPECT_THAT(
        [&] { file_names_of_rows(table_of("a,1\n" + name + ",2\n"), "name"); },
        ThrowsMessage<Error>(AllOf(HasSubstr("path.csv:3"), HasSubstr("is not a valid file name"))))
        << name;
  }
  EXPECT_THAT([&] { file_names_of_rows(table_of("a,1\nb,2\na,3\n"), "name"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("path.csv:4"), HasSubstr("appears twice"))));
}

}  // namespace
}  // namespace raywalk
