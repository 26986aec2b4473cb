#include "core/files/json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/test_error.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

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
  const auto members = root.at("lines").items()[0].members();
  ASSERT_EQ(members.size(), 1U);
  EXPECT_EQ(members[0].first, "id");
  EXPECT_EQ(members[0].second.text(), "x0");
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
        error_of([&] { read(Json::parse(kDocument, "room.json", "make it again")); });
    EXPECT_THAT(error,
                AllOf(StartsWith("room.json: "), HasSubstr(message), EndsWith(" make it again")));
  }
}

TEST(CheckedJson, IntegersNeverWrapOrRound) {
  const auto refused = [](const std::string& value) {
    return error_of(
        [&] { CheckedJson::parse("[" + value + "]", "trade.json").items()[0].integer(4, 9); });
  };
  EXPECT_EQ(refused("99999999999"), "trade.json[0]: 99999999999 is not between 4 and 9");
  for (const char* value : {"-99999999999", "4294967300", "18446744073709551615", "3", "-5"}) {
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

}  // namespace
}  // namespace raywalk
