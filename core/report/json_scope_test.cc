#include "core/report/json_scope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

class JsonScopeTest : public ::testing::Test {
 protected:
  std::string text(std::string_view text) const { return scope_.text(text); }

  Json document_ = Json::parse(R"({
    "room": "white {room}.lf", "step_m": 0.05, "bytes": 2500000, "half": 1250000, "zero": 0,
    "none": null, "no": false, "empty": [], "unnamed": "", "position_m": [1.5, 2.5],
    "truth": {"maps": 2, "within": {"1px": 0.5}},
    "lines": [{"id": "x0", "models": [{"name": "straight", "bic": 4.5}, {"name": "bow", "bic": 3}]},
              {"id": "z0", "models": [{"name": "twist", "bic": null}]}]})");
  JsonScope scope_{document_};
};

TEST_F(JsonScopeTest, TextsAreFilledWithValues) {
  EXPECT_EQ(text("no placeholder"), "no placeholder");
  EXPECT_EQ(text("{room}: {truth.maps:counted map}"), "white {room}.lf: 2 maps");
  EXPECT_EQ(text("{truth.within.1px:.1%} at ({position_m.0:g}, {position_m.1:g}) m"),
            "50.0 % at (1.5, 2.5) m");
  EXPECT_EQ(text("{none:.2f m}, {none:.2f m|sky}"), "–, sky");
  EXPECT_EQ(text("{lines:size} {{lines}} {{{zero}}}"), "2 {lines} {0}");
}

TEST_F(JsonScopeTest, PathsStartAtThePartAtHand) {
  const JsonScope truth = scope_.at("truth");
  EXPECT_EQ(truth.text("{maps} {/step_m:g} {^step_m:g} {within.1px:g}"), "2 0.05 0.05 0.5");
  EXPECT_EQ(truth.at("within").text("{^maps} {^^zero}"), "2 0");
  EXPECT_EQ(scope_.at("step_m").text("{.:length}"), "5.0 cm");
}

TEST_F(JsonScopeTest, EntriesAreThoseOfAllListsOnThePath) {
  std::string texts;
  for (const JsonScope& model : scope_.entries("lines.models")) {
    texts += model.text("{^id} {name} {bic:g}; ");
  }
  EXPECT_EQ(texts, "x0 straight 4.5; x0 bow 3; z0 twist –; ");
  EXPECT_EQ(scope_.entries("lines").at(1).text("{id}"), "z0");
  EXPECT_EQ(scope_.entries("position_m").at(0).text("{.:g} {^zero}"), "1.5 0");
  EXPECT_EQ(scope_.at("lines").entries(".").size(), 2U);
  EXPECT_EQ(scope_.at("truth").entries("/lines.models").size(), 3U);
  EXPECT_TRUE(scope_.entries("none").empty());
  EXPECT_TRUE(scope_.entries("empty").empty());
}

TEST_F(JsonScopeTest, NumbersMayBeRatiosAndInOtherUnits) {
  EXPECT_EQ(scope_.number("step_m"), 0.05);
  EXPECT_EQ(scope_.number("half / bytes"), 0.5);
  EXPECT_EQ(scope_.number("step_m as cm"), 5.0);
  EXPECT_EQ(scope_.number("bytes as MB"), 2.5);
  EXPECT_TRUE(std::isnan(scope_.number("none")));
  EXPECT_TRUE(std::isnan(scope_.number("none as cm")));
  EXPECT_EQ(text("{half / bytes:.0%}, {zero / zero:.0%}, {bytes as MB:.1f MB}"), "50 %, –, 2.5 MB");
}

TEST_F(JsonScopeTest, ConditionsHold) {
  for (const char* true_one :
       {"truth", "step_m", "lines", "room", "!none", "!no", "!zero", "!empty", "!unnamed",
        "half < bytes", "bytes > half", "half <= half", "half >= half", "lines.0.id is x0"}) {
    EXPECT_TRUE(scope_.holds(true_one)) << true_one;
    EXPECT_FALSE(scope_.holds(std::string("!") + true_one)) << true_one;
  }
  for (const char* false_one :
       {"half > bytes", "half < half", "none < half", "none >= half", "room is x0", "none is x0"}) {
    EXPECT_FALSE(scope_.holds(false_one)) << false_one;
  }
  EXPECT_EQ(text("{half < bytes:less|more} {!no} {lines.0.id is z0:end|}"), "less yes ");
}

TEST_F(JsonScopeTest, WhatTheDocumentLacksIsAnErrorOfTheProgram) {
  for (const char* wrong :
       {"{rooms}", "{truth.map}", "{room.name}", "{none.maps}", "{position_m.2}", "{position_m.x}",
        "{^room}", "{lines.id}", "{}", "{step_m", "step_m}", "{step_m:fx}", "{step_m + half:g}",
        "{room as cm:g}", "{step_m as ft:g}", "{room < half}", "{room  is x}"}) {
    EXPECT_THROW(text(wrong), std::logic_error) << wrong;
  }
  EXPECT_THROW((void)scope_.entries("room"), std::logic_error);
  EXPECT_THROW((void)scope_.entries("lines.points"), std::logic_error);
  EXPECT_THROW((void)scope_.holds("rooms"), std::logic_error);
  EXPECT_THROW((void)scope_.number("lines"), std::logic_error);
}

}  // namespace
}  // namespace raywalk
