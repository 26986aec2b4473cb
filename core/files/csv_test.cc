#include "core/files/csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "core/base/test_error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

CsvTable poses(const std::string& text) {
  return CsvTable::parse(text, "poses.csv", {"file", "x", "y", "z"}, {"yaw", "pitch", "roll"});
}

std::string table_error(const std::string& text) {
  return error_of([&] {
    const CsvTable table = poses(text);
    for (std::size_t row = 0; row < table.rows(); ++row) table.number(row, "x");
  });
}

TEST(CsvTable, ReadsNumbersAndTextInAnyColumnOrder) {
  const CsvTable table = poses("x,file,z,y\n -0.5 ,front_000.jpg,1e-3,+2\n.25,b.jpg,-7,0\n");
  ASSERT_EQ(table.rows(), 2U);
  EXPECT_EQ(table.text(0, "file"), "front_000.jpg");
  EXPECT_EQ(table.number(0, "x"), -0.5);
  EXPECT_EQ(table.number(0, "y"), 2.0);
  EXPECT_EQ(table.number(0, "z"), 1e-3);
  EXPECT_EQ(table.number(1, "x"), 0.25);
  EXPECT_FALSE(table.has_column("yaw"));
  EXPECT_TRUE(table.has_column("z"));
  EXPECT_THROW(table.number(0, "yaw"), std::logic_error);
}

TEST(CsvTable, AcceptsWhatSpreadsheetsWrite) {
  const CsvTable table = poses(
      "\xEF\xBB\xBF"
      "file,x,y,z\r\na.jpg,1,2,3\r\n\"b, c.jpg\", 4 ,5,6");
  ASSERT_EQ(table.rows(), 2U);
  EXPECT_EQ(table.number(0, "z"), 3.0);
  EXPECT_EQ(table.text(1, "file"), "b, c.jpg");
}

TEST(CsvTable, QuotedFieldsFollowRfc4180) {
  const CsvTable table = poses(
      "file,x,y,z\n \"a, \"\"b\"\"\" ,1,2,3\n\"two\nlines\",1,2,3\n\"\",1,2,3\n"
      "\"\"\"\",1,2,3\n");
  ASSERT_EQ(table.rows(), 4U);
  EXPECT_EQ(table.text(0, "file"), "a, \"b\"");
  EXPECT_EQ(table.text(1, "file"), "two\nlines");
  EXPECT_EQ(table.text(2, "file"), "");
  EXPECT_EQ(table.text(3, "file"), "\"");
  EXPECT_EQ(table.where(2), "poses.csv:5") << "the field of two lines counts as two";
}

TEST(CsvTable, BlankLinesAndCommentsAreSkippedButCounted) {
  EXPECT_EQ(poses("file,x,y,z").rows(), 0U);
  const CsvTable table = poses("# captured by hand\n\nfile,x,y,z\n  \t\n#a,1\na.jpg,1,2,3\n");
  ASSERT_EQ(table.rows(), 1U);
  EXPECT_EQ(table.where(0), "poses.csv:6");
}

TEST(CsvTable, ARowThatLooksLikeACommentIsNotLeftOut) {
  EXPECT_THAT(table_error("file,x,y,z\n#5.jpg,1,2,3\n"),
              AllOf(HasSubstr("poses.csv:2"), HasSubstr("begins with '#'"), HasSubstr("quotes")));
  EXPECT_EQ(poses("file,x,y,z\n\"#5.jpg\",1,2,3\n# 6.jpg,1,2,3\n").text(0, "file"), "#5.jpg");
  EXPECT_EQ(poses("#file,x,y,z\nfile,x,y,z\n").rows(), 0U);
}

TEST(CsvTable, HeaderErrorsNameTheRequiredColumns) {
  EXPECT_EQ(table_error(""), "poses.csv: empty; a header line with file,x,y,z is needed");
  EXPECT_EQ(table_error("# nothing\n\n"), table_error(""));
  EXPECT_EQ(table_error("file,x,z\n"), "poses.csv:1: no column 'y'; the header needs file,x,y,z");
  EXPECT_EQ(table_error("\nfile,x,y,z,ptich\n"),
            "poses.csv:2: unknown column 'ptich'; did you mean 'pitch'?");
  EXPECT_EQ(table_error("file,x,y,z,temperature\n"),
            "poses.csv:1: unknown column 'temperature'; valid are file, x, y, z, yaw, pitch, roll");
  EXPECT_EQ(table_error("file,x,y,z,x\n"), "poses.csv:1: column 'x' appears twice");
  EXPECT_THAT(table_error("file,x,y,z,\n"), StartsWith("poses.csv:1: unknown column ''"));
}

TEST(CsvTable, AMissingFileIsNamedWithTheColumnsItNeeds) {
  EXPECT_EQ(error_of([] {
              CsvTable::read("nowhere/walk.csv", {"name", "x", "z"}, {"y"});
            }),
            "nowhere/walk.csv: no such file; give a table with the columns name,x,z");
}

TEST(CsvTable, RowsOfAnotherLengthAndBinaryDataAreErrors) {
  EXPECT_THAT(table_error(std::string("file,x,y,z\n\0\0", 13)), HasSubstr("binary data"));
  EXPECT_EQ(table_error("file,x,y,z\na.jpg,1,2,3\nb.jpg,1,2\n"),
            "poses.csv:3: 3 fields where the header has 4 (file,x,y,z)");
  EXPECT_THAT(table_error("file,x,y,z\nb.jpg,1,2,3,\n"), StartsWith("poses.csv:2: 5 fields"));
}

TEST(CsvTable, OtherSeparatorsAreNamedWithWhatToDo) {
  const std::string advice =
      "; separate them by commas and write decimals with a point (0.5, not 0,5)";
  const std::string semicolons = "its fields are separated by semicolons" + advice;
  EXPECT_EQ(table_error("file;x;y;z\na.jpg;1;2;3\n"), "poses.csv:1: " + semicolons);
  EXPECT_EQ(table_error("file,x,y,z\na.jpg;1;2;3\n"), "poses.csv:2: " + semicolons);
  EXPECT_EQ(table_error("file;x;y;z\na.jpg;0,5;2;3\n"), "poses.csv:1: " + semicolons);
  EXPECT_EQ(table_error("file\tx\ty\tz\na.jpg\t1\t2\t3\n"),
            "poses.csv:1: its fields are separated by tabs" + advice);
  // As many commas as the header has.
  EXPECT_EQ(table_error("file,x,y,z\na.jpg;0,5;2,5;1,5\n"),
            "poses.csv:2: column 'x': '5;2' is not a finite number; " + semicolons);
}

TEST(CsvTable, DecimalCommasAreNamedWithWhatToDo) {
  EXPECT_EQ(
      table_error("file,x,y,z\na.jpg,1.5,0,0\nb.jpg,1,5,0,0\n"),
      "poses.csv:3: 5 fields where the header has 4 (file,x,y,z); write decimals with a point "
      "(0.5, not 0,5), and put a field that holds a comma in quotes");
  for (const std::string decimal : {"0,5", "-1,25", "1.000,5"}) {
    EXPECT_EQ(table_error("file,x,y,z\na.jpg,\"" + decimal + "\",0,0\n"),
              "poses.csv:2: column 'x': '" + decimal +
                  "' is not a finite number; write decimals with a point (0.5, not 0,5)");
  }
}

TEST(CsvTable, MalformedQuotesAreErrorsWithTheirLine) {
  EXPECT_EQ(table_error("file,x,y,z\n\"a.jpg,1,2,3\nb.jpg,1,2,3\n"),
            "poses.csv:2: a quoted field has no closing quote");
  EXPECT_THAT(table_error("file,x,y,z\n\"a\" b,1,2,3\n"), StartsWith("poses.csv:2: text after"));
  EXPECT_THAT(table_error("file,x,y,z\na\"b\",1,2,3\n"), StartsWith("poses.csv:2: a quote inside"));
}

TEST(CsvTable, OnlyFiniteNumbersAreNumbers) {
  for (const std::string bad : {"nan", "1e999", "", "1 2", "\"1,5\""}) {
    const std::string error = table_error("file,x,y,z\na.jpg," + bad + ",2,3\n");
    EXPECT_THAT(error, StartsWith("poses.csv:2: column 'x': '")) << bad;
    EXPECT_THAT(error, HasSubstr("is not a finite number")) << bad;
  }
}

TEST(CsvTable, ErrorsStayOneLineWhateverTheFieldHolds) {
  const std::string error = table_error("file,x,y,z\na.jpg,\"1\n\x1b[2J\",2,3\n");
  EXPECT_EQ(error.find_first_of("\n\x1b"), std::string::npos) << error;
}

CsvTable path_of(const std::string& rows) {
  return CsvTable::parse("name,x\n" + rows, "path.csv", {"name", "x"}, {});
}

TEST(FileNamesOfRows, AreThoseOfTheRowsButInvalidAndDuplicateOnesAreRejected) {
  EXPECT_THAT(file_names_of_rows(path_of("b,1\na,2\n" + std::string(200, 'c') + ",3\n"), "name"),
              testing::ElementsAre("b", "a", std::string(200, 'c')));
  for (const std::string& name :
       std::vector<std::string>{"../a", "/a", ".a", R"("")", R"("a,b")", R"("a""b")", "\"a\nb\"",
                                "\"a\rb\"", std::string(201, 'c')}) {
    EXPECT_THAT(error_of([&] { file_names_of_rows(path_of("a,1\n" + name + ",2\n"), "name"); }),
                AllOf(HasSubstr("path.csv:3"), HasSubstr("is not a valid file name")))
        << name;
  }
  EXPECT_THAT(error_of([&] { file_names_of_rows(path_of("a,1\nb,2\na,3\n"), "name"); }),
              AllOf(HasSubstr("path.csv:4"), HasSubstr("appears twice")));
}

TEST(ParseFiniteNumber, RequiresTheWholeText) {
  EXPECT_EQ(parse_finite_number("+1.5"), 1.5);
  for (const char* bad : {"", " 1", "1 ", "1,5", "0x1p3", "+", "-", "+-1", "++1", "nan", "inf",
                          "1e400", "1e", "1_0", "1f"}) {
    EXPECT_FALSE(parse_finite_number(bad)) << bad;
  }
}

TEST(ParseWholeNumber, CoversExactlyTheRangeOfInt) {
  EXPECT_EQ(parse_whole_number("2147483647"), std::numeric_limits<int>::max());
  EXPECT_EQ(parse_whole_number("-2147483648"), std::numeric_limits<int>::min());
  for (const char* bad : {"2147483648", "-2147483649", "1.0", "1e3", "", "x", "0x10"}) {
    EXPECT_FALSE(parse_whole_number(bad)) << bad;
  }
}

TEST(NearestWord, IsTheClosestAndNoneOfDifferentWords) {
  const std::vector<std::string> columns = {"file", "x", "y", "z", "yawn", "yaw", "pitch", "roll"};
  EXPECT_EQ(nearest_word("rol", columns), "roll");
  EXPECT_EQ(nearest_word("files", columns), "file");
  EXPECT_EQ(nearest_word("yax", columns), "yaw");
  EXPECT_EQ(nearest_word("--yaw", {"--at", "--yaw-deg"}), "--yaw-deg") << "the unit is missing";
  EXPECT_FALSE(nearest_word("temperature", columns));
  EXPECT_FALSE(nearest_word("q", columns)) << "a letter resembles no other letter";
  EXPECT_FALSE(nearest_word("", columns));
  EXPECT_FALSE(nearest_word("yaw", {}));
}

TEST(NearestWord, AKeyMayStandInTheWrongGroup) {
  const std::vector<std::string> keys = {"grid.k_deg", "slider.motion.speed_mm_s", "run.shots"};
  for (const char* word : {"speed_mm_s", "speed", "motion.speed"}) {
    EXPECT_EQ(nearest_word(word, keys), "slider.motion.speed_mm_s") << word;
  }
  EXPECT_EQ(nearest_word("camera.shots", keys), "run.shots");
  EXPECT_EQ(nearest_word("motion.sped_mm_s", keys), "slider.motion.speed_mm_s");
  EXPECT_FALSE(nearest_word("grid.temperature", keys));
}

TEST(Suggestion, NamesTheNearestOfManyFirst) {
  std::vector<std::string> keys;
  for (int i = 0; i < 70; ++i) keys.push_back(fmt::format("group.other_{}", i));
  keys.emplace_back("slider.motion.acceleration_mm_s2");
  EXPECT_THAT(suggestion("slider.accel", keys),
              testing::MatchesRegex("; the nearest valid ones are "
                                    "'slider.motion.acceleration_mm_s2', '[a-z_.0-9]+', "
                                    "'[a-z_.0-9]+'"));
  EXPECT_LT(suggestion(std::string(1 << 20, 'x'), keys).size(), 200U);
}

}  // namespace
}  // namespace raywalk
