// Tables, JSON documents, lists of frames, and the fingerprints of files.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/fingerprint.h"
#include "core/files/frame_list.h"
#include "core/files/json.h"
#include "core/files/listed_files.h"
#include "core/files/test_support.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;
namespace fs = std::filesystem;

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
  const std::string missing = error_of([] {
    CsvTable::read("nowhere/walk.csv", {"name", "x", "z"}, {"y"});
  });
  EXPECT_EQ(missing, "nowhere/walk.csv: no such file; give a table with the columns name,x,z");
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

TEST(CsvTable, RowsThatCannotBeReadAreErrorsWithTheirLine) {
  EXPECT_THAT(table_error(std::string("file,x,y,z\n\0\0", 13)), HasSubstr("binary data"));
  EXPECT_EQ(table_error("file,x,y,z\na.jpg,1,2,3\nb.jpg,1,2\n"),
            "poses.csv:3: 3 fields where the header has 4 (file,x,y,z)");
  EXPECT_THAT(table_error("file,x,y,z\nb.jpg,1,2,3,\n"), StartsWith("poses.csv:2: 5 fields"));
  EXPECT_EQ(table_error("file,x,y,z\n\"a.jpg,1,2,3\nb.jpg,1,2,3\n"),
            "poses.csv:2: a quoted field has no closing quote");
  EXPECT_THAT(table_error("file,x,y,z\n\"a\" b,1,2,3\n"), StartsWith("poses.csv:2: text after"));
  EXPECT_THAT(table_error("file,x,y,z\na\"b\",1,2,3\n"), StartsWith("poses.csv:2: a quote inside"));
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

TEST(CsvTable, OnlyFiniteNumbersAreNumbersAndErrorsStayOneLine) {
  for (const std::string bad : {"nan", "1e999", "", "1 2", "\"1,5\""}) {
    const std::string error = table_error("file,x,y,z\na.jpg," + bad + ",2,3\n");
    EXPECT_THAT(error, StartsWith("poses.csv:2: column 'x': '")) << bad;
    EXPECT_THAT(error, HasSubstr("is not a finite number")) << bad;
  }
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

TEST(JsonText, KeepsWhatJsonCannotHoldReadable) {
  nlohmann::ordered_json document{{"z", 1}, {"a", std::numeric_limits<double>::infinity()}};
  document["file"] = "\xff.png";
  EXPECT_EQ(json_text(document), "{\n  \"z\": 1,\n  \"a\": null,\n  \"file\": \"\ufffd.png\"\n}\n");
}

constexpr const char* kDocument = R"({
  "format_version": 2, "name": "x0", "names": ["a", "b"], "kept": true, "count": 7, "low": -7,
  "far": 1e300, "none": null, "place": [1, 2.5],
  "lines": [{"id": "x0"}, {"id": 7}]
})";

TEST(CheckedJson, GivesWhatIsThere) {
  const CheckedJson root = CheckedJson::parse(kDocument, "room.json");
  EXPECT_EQ(root.at("name").text(), "x0");
  EXPECT_THAT(root.at("names").texts(), ElementsAre("a", "b"));
  EXPECT_TRUE(root.at("kept").boolean());
  EXPECT_EQ(root.at("count").integer(), 7);
  EXPECT_EQ(root.at("low").integer(-7, -7), -7);
  EXPECT_EQ(root.at("place").items(2)[1].number(), 2.5);
  EXPECT_EQ(root.at("count").number(), 7.0);
  EXPECT_EQ(root.at("far").number(), 1e300);
  const auto [key, value] = root.at("lines").items()[0].members().at(0);
  EXPECT_EQ(key + " " + value.text(), "id x0");
  EXPECT_TRUE(root.at("none").is_null());
  EXPECT_TRUE(root.has("none"));
  EXPECT_FALSE(root.has("some"));
  EXPECT_FALSE(root.at("name").has("some"));
  EXPECT_NO_THROW(root.require_version(2));
}

TEST(CheckedJson, ErrorsNameTheFileThePlaceAndTheRemedy) {
  using Json = CheckedJson;
  const std::vector<std::pair<std::function<void(const Json&)>, std::string>> errors = {
      {[](const Json& root) { root.at("lines").items()[1].at("id").text(); },
       "lines[1]: id: 7 is not a string"},
      {[](const Json& root) { root.at("lines").items()[1].at("axis"); }, "lines[1]: has no 'axis'"},
      {[](const Json& root) { root.require_version(1); },
       "format version 2 is newer than 1, the newest this program reads; use a newer Raywalk, or"},
      {[](const Json& root) { root.at("name").fail("is\nodd"); }, "name: is\nodd"},
      {[](const Json& root) { root.at("count").text(); }, "count: 7 is not a string"},
      {[](const Json& root) { root.at("place").texts(); }, "place[0]: 1 is not a string"},
      {[](const Json& root) { root.at("count").boolean(); }, "count: 7 is not a boolean"},
      {[](const Json& root) { root.at("kept").number(); }, "kept: true is not a number"},
      {[](const Json& root) { root.at("name").items(); }, "name: \"x0\" is not a list"},
      {[](const Json& root) { root.at("names").at("id"); }, "is not an object"},
      {[](const Json& root) { root.at("names").members(); }, "is not an object"},
      {[](const Json& root) { root.at("count").number(7.5, 9); },
       "count: 7 is not between 7.5 and 9"},
      {[](const Json& root) { root.at("place").items(3); }, "place: does not have 3 elements"}};
  for (const auto& [read, message] : errors) {
    const std::string error =
        error_of([&read = read] { read(Json::parse(kDocument, "room.json", "make it again")); });
    EXPECT_THAT(error,
                AllOf(StartsWith("room.json: "), HasSubstr(message), EndsWith(" make it again")));
  }
}

TEST(CheckedJson, IntegersNeverWrapOrRound) {
  const auto refused = [](const std::string& value) {
    return error_of(
        [&] { CheckedJson::parse("[" + value + "]", "trade.json").items()[0].integer(4, 9); });
  };
  for (const char* value :
       {"99999999999", "-99999999999", "4294967300", "18446744073709551615", "3", "-5"}) {
    EXPECT_EQ(refused(value), "trade.json[0]: " + std::string(value) + " is not between 4 and 9");
  }
  // 4294967300 and 18446744073709551620 are 4 modulo 2^32 and 2^64; the latter is read as a double.
  for (const char* value :
       {"4.5", "5.0", "1e3", "18446744073709551620", "null", "\"5\"", "true", "[5]", "-0.0"}) {
    EXPECT_THAT(refused(value), HasSubstr("is not an integer between 4 and 9")) << value;
  }
  EXPECT_THAT(refused("\"" + std::string(1000, 'x') + "\""), HasSubstr("xxx... is not an integer"));
}

TEST(CheckedJson, TextThatIsNotJsonIsOneLineOfError) {
  for (const std::string& text :
       std::vector<std::string>{"", "{", "1e999", "\xff\xfe", "{\"a\":\n\"b\nc\"}",
                                std::string(kDocument).substr(0, 60)}) {
    const std::string error = error_of([&] { CheckedJson::parse(text, "room.json"); });
    EXPECT_THAT(error, StartsWith("room.json: damaged (")) << text;
    EXPECT_EQ(error.find('\n'), std::string::npos) << text;
  }
  EXPECT_EQ(error_of([] { CheckedJson::parse(std::string(100000, '['), "room.json"); }),
            "room.json: nested too deeply");
}

class FrameListTest : public ::testing::Test {
 protected:
  std::vector<Frame> read(const std::string& text) {
    write_file_atomically(list_, text);
    return read_frame_list(list_);
  }
  std::string error_in(const std::string& text) {
    return error_of([&] { read(text); });
  }

  TestDirectory directory_;
  std::filesystem::path list_ = directory_ / "poses.csv";
};

TEST_F(FrameListTest, AnglesAreDegreesAndMissingOnesZero) {
  const std::vector<Frame> frames =
      read("file,x,y,z,yaw,roll\na.jpg,0,0,0,90,-45\nb.jpg,0,0,1,0,0\n");
  ASSERT_TRUE(frames[0].attitude.has_value());
  EXPECT_DOUBLE_EQ(frames[0].attitude->yaw_rad, kHalfPi);
  EXPECT_DOUBLE_EQ(frames[0].attitude->pitch_rad, 0.0);
  EXPECT_DOUBLE_EQ(frames[0].attitude->roll_rad, -0.25 * kPi);
  EXPECT_FALSE(frames[1].attitude.has_value());
}

TEST_F(FrameListTest, OtherColumnsAreIgnoredWhereThatIsSaid) {
  const std::string text = "file,x,y,z,distance\na.jpg,0,0,0,a.png\n";
  EXPECT_THAT(error_in(text), HasSubstr("distance"));
  EXPECT_EQ(read_frame_list(list_, {"distance"})[0].file, "a.jpg");
}

TEST_F(FrameListTest, BadRowsAreNamedByLine) {
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,0\nb.jpg,nan,0,0\n"), HasSubstr("poses.csv:3"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,2000000\n"), HasSubstr("position in metres"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,1e308,0\n"),
              AllOf(HasSubstr("poses.csv:2: y = 1e+308"), HasSubstr("correct the unit")));
  EXPECT_THAT(error_in("file,x,y,z,yaw\na.jpg,0,0,0,1e308\n"),
              AllOf(HasSubstr("poses.csv:2: yaw = 1e+308"), HasSubstr("angle in degrees")));
  EXPECT_THAT(error_in("file,x,y,z\n,0,0,0\n"), HasSubstr("names no file"));
  EXPECT_THAT(error_in("file,x,y,z\n"), HasSubstr("no frames"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,0\nb.jpg,0,0,1\na.jpg,1,0,0\n"),
              AllOf(HasSubstr("poses.csv:4"), HasSubstr("poses.csv:2"), HasSubstr("a.jpg")));
}

TEST_F(FrameListTest, TextRoundTrips) {
  const Attitude attitude{0.1, -0.2, 3.0};
  const std::vector<Frame> back =
      read(frame_list_text({{.file = "plain.png",
                             .position_m = {1.0 / 3.0, -0.0, 1e-9},
                             .mask = "masks/plain.png",
                             .line = "x0"},
                            {.file = "a, \"b\".png", .position_m = {0, 0, 0}, .attitude = attitude},
                            {.file = "#x.png", .position_m = {-5, 2, 1}}}));
  ASSERT_EQ(back.size(), 3U);
  EXPECT_EQ(back[0].file, "plain.png");
  EXPECT_NEAR(back[0].position_m.x(), 1.0 / 3.0, 1e-9);
  EXPECT_FALSE(back[0].attitude);
  EXPECT_EQ(back[0].mask.value().filename(), "plain.png");
  EXPECT_EQ(back[0].line, "x0");
  EXPECT_EQ(back[1].line, "");
  EXPECT_EQ(back[1].file, "a, \"b\".png");
  EXPECT_NEAR(back[1].attitude.value().roll_rad, 3.0, 1e-9);
  EXPECT_FALSE(back[1].mask);
  EXPECT_EQ(back[2].file, "#x.png");
  // Columns are there only where they are needed.
  EXPECT_EQ(frame_list_text({{.file = "a.png", .position_m = {1, -1e-12, -2}}}),
            "file,x,y,z\na.png,1.000000000,0.000000000,-2.000000000\n");
}

TEST(FrameNames, AreStemsOrPaths) {
  EXPECT_THAT(frame_names(std::vector<std::string>{"a/0.png", "b/1.png"}, "poses.csv"),
              ::testing::ElementsAre("0", "1"));
  EXPECT_THAT(frame_names(std::vector<std::string>{"a/0.png", "b/0.png"}, "poses.csv"),
              ::testing::ElementsAre("a_0", "b_0"));
  EXPECT_THROW(frame_names(std::vector<std::string>{"a/0.png", "a/0.jpg"}, "poses.csv"), Error);
}

TEST(ListedFiles, NamesOfOtherSystemsAreFound) {
  const TestDirectory directory;
  const std::string composed = "K\u00fcche.jpg", decomposed = "Ku\u0308che.jpg";
  fs::create_directories(directory / "Hall/Front");
  for (const std::string name : {"Hall/Front/a.JPG", "b.jpg", "B.jpg", "\xFFg.jpg", "a\\b.jpg"}) {
    write_file_atomically(directory / name, name);
  }
  write_file_atomically(directory / decomposed, "");
  ListedFiles files(directory.path());
  const auto found = [&](const std::string& name) {
    return files.find(name).lexically_relative(directory.path()).string();
  };
  EXPECT_EQ(found("Hall/Front/a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall\\Front\\a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("hall\\FRONT\\A.jpg"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall/../hall/./Front/a.jpg"), "Hall/../Hall/./Front/a.JPG");
  EXPECT_EQ(found(composed), decomposed);
  EXPECT_EQ(found(decomposed), decomposed);
  EXPECT_EQ(found("\xFFg.JPG"), "\xFFg.JPG") << "not UTF-8";
  EXPECT_EQ(found("b.jpg"), "b.jpg");
  EXPECT_EQ(found("b.JPG"), "b.JPG") << "two files have this name but for case";
  EXPECT_EQ(found("none\\c.jpg"), "none\\c.jpg");
  EXPECT_EQ(found("a\\b.jpg"), "a\\b.jpg") << "a file has this very name";
  EXPECT_EQ(files.find((directory / "HALL/front/a.jpg").string()), directory / "Hall/Front/a.JPG");
}

// Examples of FIPS 180-2, appendix B, and the empty message.
TEST(Fingerprint, GivesThePublishedChecksums) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Fingerprint, OfPixelsDoesNotDependOnGapsBetweenRows) {
  const cv::Mat whole = (cv::Mat_<std::uint8_t>(2, 3) << 'a', 'b', 'x', 'c', 'd', 'x');
  const cv::Mat part = whole.colRange(0, 2);
  ASSERT_FALSE(part.isContinuous());
  EXPECT_EQ(sha256_of_pixels(part), sha256_hex("abcd"));
}

TEST(Fingerprint, OfAFileIsThatOfItsBytesAndItsStampChangesWithSizeAndTime) {
  const TestDirectory directory;
  const fs::path file = directory / "frame.png";
  write_file_atomically(file, "abc");
  EXPECT_EQ(sha256_of_file(file), sha256_hex("abc"));
  EXPECT_THROW(sha256_of_file(directory / "nothing.png"), Error);
  EXPECT_THROW(sha256_of_file(directory.path()), Error);
  const std::string before = stamp_of(file).text();
  EXPECT_EQ(stamp_of(file).bytes, 3U);
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(1));
  EXPECT_NE(stamp_of(file).text(), before);
  EXPECT_THAT(error_of([&] { stamp_of(directory / "nothing.png"); }),
              testing::HasSubstr("nothing.png: cannot be read"));
}

}  // namespace
}  // namespace raywalk
