#include "core/report/json_format.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

TEST(JsonFormat, NumbersAreAsPrintfWritesThem) {
  EXPECT_EQ(formatted(3.14159, ".2f"), "3.14");
  EXPECT_EQ(formatted(0.5, ".3g"), "0.5");
  EXPECT_EQ(formatted(76.0, "g"), "76");
  EXPECT_EQ(formatted(1234.5, ".1e"), "1.2e+03");
  EXPECT_EQ(formatted(0.25, "+.2f"), "+0.25");
  EXPECT_EQ(formatted(7, ".1f"), "7.0");
  EXPECT_EQ(formatted(-0.001, ".2f"), "0.00");
  EXPECT_EQ(formatted(-0.001, "+.2f"), "0.00");
  EXPECT_EQ(formatted(-0.001, ".1e"), "-1.0e-03");
}

TEST(JsonFormat, UnitsFollowNumbers) {
  EXPECT_EQ(formatted(12.4, ".0f s"), "12 s");
  EXPECT_EQ(formatted(12.4, ".1f°"), "12.4°");
  EXPECT_EQ(formatted(640, " px"), "640 px");
  EXPECT_EQ(formatted(0.4567, ".1%"), "45.7 %");
  EXPECT_EQ(formatted(0.4567, ".2g%"), "46 %");
  EXPECT_EQ(formatted(1, ".0% of all"), "100 % of all");
}

TEST(JsonFormat, WholeNumbersTextsAndTruthNeedNoFormat) {
  EXPECT_EQ(formatted(68, ""), "68");
  EXPECT_EQ(formatted("a text", ""), "a text");
  EXPECT_EQ(formatted(true, ""), "yes");
  EXPECT_EQ(formatted(false, ""), "no");
  EXPECT_EQ(formatted(true, "high|low"), "high");
  EXPECT_EQ(formatted(false, "high|low"), "low");
  EXPECT_EQ(formatted(false, ", again|"), "");
}

TEST(JsonFormat, NothingIsADashOrTheOtherwise) {
  for (const Json& nothing : {Json(nullptr), Json(std::numeric_limits<double>::quiet_NaN()),
                              Json(std::numeric_limits<double>::infinity())}) {
    EXPECT_TRUE(is_nothing(nothing));
    EXPECT_EQ(formatted(nothing, ".2f m"), "–");
    EXPECT_EQ(formatted(nothing, ".2f m|sky"), "sky");
    EXPECT_EQ(formatted(nothing, "|"), "");
  }
  EXPECT_EQ(formatted(1.5, ".2f m|sky"), "1.50 m");
}

TEST(JsonFormat, LengthsAreInUnitsOfTheirSize) {
  EXPECT_EQ(formatted(0.00123, "length"), "1.2 mm");
  EXPECT_EQ(formatted(0.0625, "length"), "6.2 cm");
  EXPECT_EQ(formatted(nullptr, "length|any"), "any");
}

TEST(JsonFormat, CountsHaveTheirNoun) {
  EXPECT_EQ(formatted(1, "counted line"), "1 line");
  EXPECT_EQ(formatted(3, "counted held-out view"), "3 held-out views");
  EXPECT_EQ(formatted(Json::array({1, 2}), "counted line"), "2 lines");
  EXPECT_EQ(formatted(Json::array(), "size"), "0");
  EXPECT_EQ(formatted(Json::array({"a", "b", 3}), "joined"), "a, b, 3");
}

TEST(JsonFormat, WhatDoesNotFitIsAnError) {
  const auto refused = [](const Json& value, const char* format) {
    EXPECT_THROW(formatted(value, format), std::logic_error) << value << " " << format;
  };
  refused(0.5, "");  // would show digits that mean nothing
  refused(0.5, " m");
  refused(0.5, "counted line");
  refused(1, "cuonted line");
  refused(1, ".2x");
  refused(1, ".f m");
  refused("text", ".2f");
  refused("text", "counted line");
  refused(true, ".2f");
  refused(Json::array(), "");
  refused(Json::object(), "");
  refused(Json::object(), "size");
}

}  // namespace
}  // namespace raywalk
