#include "core/report/json_page.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/report/markup_check.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::ordered_json;

class JsonPageTest : public ::testing::Test {
 protected:
  // The page so far, which has to be well-formed.
  std::string html() const {
    std::string html = page_.html();
    EXPECT_EQ(markup_fault(html), "");
    return html;
  }

  Json document_ = Json::parse(R"({
    "room": "<white>.lf", "psnr_db": 34.25, "views": 2, "none": null, "empty": [],
    "warnings": ["a < b", "{x}"],
    "truth": {"maps": 2, "share": 0.25},
    "scores": [{"name": "fast", "line": "x0", "at": 0, "db": 30.5, "ms": 4.5, "good": true},
               {"name": "best", "line": "x0", "at": 1, "db": 38.5, "ms": null, "good": false},
               {"name": "<odd>", "line": "z0", "at": 0, "db": 34.0, "ms": 9.5, "good": false}]})");
  JsonPage page_{document_, "Views of {room}", "{views:counted view}"};
};

TEST_F(JsonPageTest, FillsEveryText) {
  page_.facts({{"PSNR of {views}", "{psnr_db:.1f dB}"}});
  page_.section("Section {views}", "anchor").paragraph("Paragraph {views}.");
  page_.paragraphs("warnings", "Note: {.}.");
  for (const char* text : {"<h1>Views of &lt;white&gt;.lf</h1>", "2 views", "<dt>PSNR of 2</dt>",
                           "<dd>34.2 dB</dd>", "<h2 id=\"anchor\">Section 2</h2>",
                           "<p>Paragraph 2.</p>", "<p>Note: a &lt; b.</p>", "<p>Note: {x}.</p>"}) {
    EXPECT_THAT(html(), HasSubstr(text));
  }
}

TEST_F(JsonPageTest, FactsAreShownUnderTheirCondition) {
  page_.facts(
      {{"first", "1", "truth"}, {"second", "{none.maps}", "none"}, {"third", "3", "!none"}});
  EXPECT_THAT(html(), HasSubstr("first"));
  EXPECT_THAT(html(), Not(HasSubstr("second")));
  EXPECT_THAT(html(), HasSubstr("third"));
  const std::string before = html();
  page_.facts({{"fourth", "4", "none"}});
  EXPECT_EQ(html(), before);
}

TEST_F(JsonPageTest, APartWithoutContentAddsNothing) {
  const std::string before = html();
  const std::vector<JsonPage> parts{page_.within("none"),
                                    page_.within("empty"),
                                    page_.when("none"),
                                    page_.within("none").within("maps"),
                                    page_.when("none").when("truth"),
                                    page_.within("truth").when("share > maps")};
  for (JsonPage part : parts) {
    part.section("Section").paragraph("{maps}").paragraphs("maps").warnings("warnings");
    part.facts({{"maps", "{maps}"}}).table("maps", {{"maps", "{.}"}});
    part.table({.header = {"maps"}, .rows = {{"", {{"{maps}"}}}}}).cards("maps", {}, {});
    part.figures({{"<svg/>", "caption"}}).figures({part.plot({}, {{"maps"}}, "{maps}")});
    EXPECT_TRUE(part.parts("maps").empty());
    EXPECT_EQ(html(), before);
  }
  page_.warnings("empty").table("empty", {{"a", "{b}"}}, "A caption");
  page_.figures({page_.when("none").plot({}, {}, "")});
  EXPECT_EQ(html(), before);
}

TEST_F(JsonPageTest, PathsOfAPartStartThere) {
  page_.within("truth").section("Truth").paragraph("{maps} of {/views}: {share:.0%}");
  EXPECT_THAT(html(), HasSubstr("<h2>Truth</h2>\n<p>2 of 2: 25 %</p>"));
  for (JsonPage& score : page_.parts("scores")) score.paragraph("{name} of {^room}");
  EXPECT_THAT(html(), HasSubstr("<p>best of &lt;white&gt;.lf</p>"));
  EXPECT_EQ(page_.parts("scores").at(2).text("{name}"), "<odd>");
}

TEST_F(JsonPageTest, WarningsStandUnderTheirHeading) {
  page_.warnings("warnings");
  EXPECT_THAT(html(), HasSubstr("<h2>Warnings</h2>\n<p>a &lt; b</p>\n<p>{x}</p>"));
}

TEST_F(JsonPageTest, ATableHasARowForEachEntry) {
  page_.table("scores", {{"of {room}", "{name}", "", "#{name}"}, {"PSNR", "{db:.1f}", "good"}},
              "Of {views:counted view}");
  EXPECT_THAT(html(), HasSubstr("<p>Of 2 views</p>"));
  EXPECT_THAT(html(), HasSubstr("<th scope=\"col\">of &lt;white&gt;.lf</th>"));
  EXPECT_THAT(html(), HasSubstr("<th scope=\"row\"><a href=\"#fast\">fast</a></th>"
                                "<td class=\"best\">30.5</td>"));
  EXPECT_THAT(html(), HasSubstr("<a href=\"#&lt;odd&gt;\">&lt;odd&gt;</a></th><td>34.0</td>"));
}

TEST_F(JsonPageTest, TheLargestAndTheLeastOfAColumnAreEmphasised) {
  page_.table(
      "scores",
      {{"name", "{name}"}, {"PSNR", "{db:.1f}", "largest db"}, {"time", "{ms:.1f}", "least ms"}});
  const std::string page = html();
  EXPECT_THAT(page, HasSubstr("<td class=\"best\">38.5</td><td>–</td>"));
  EXPECT_THAT(page, HasSubstr("<td>30.5</td><td class=\"best\">4.5</td>"));
  EXPECT_THAT(page, HasSubstr("<td>34.0</td><td>9.5</td>"));
  // A row alone is no comparison.
  document_["scores"].erase(1);
  document_["scores"].erase(1);
  JsonPage alone(document_, "");
  alone.table("scores", {{"name", "{name}"}, {"PSNR", "{db:.1f}", "largest db"}});
  EXPECT_THAT(alone.html(), HasSubstr("<td>30.5</td>"));
}

TEST_F(JsonPageTest, ATableMayHaveOtherRowsBesideThoseOfAList) {
  page_.table({.caption = "Rows",
               .header = {"what", "value"},
               .rows = {{"", {{"all"}, {"{psnr_db:.1f}", "views > psnr_db"}}},
                        {"", {{"nothing"}, {"{none.maps}"}}, "none"},
                        {"scores", {{"{name}"}, {"{db:.1f}", "db > ^psnr_db"}}}}});
  EXPECT_THAT(html(), HasSubstr("all</th><td>34.2</td></tr>\n<tr><th scope=\"row\">fast</th>"
                                "<td>30.5</td></tr>\n<tr><th scope=\"row\">best</th>"
                                "<td class=\"best\">38.5</td>"));
}

TEST_F(JsonPageTest, CardsAreMadeOfEntries) {
  page_.cards("scores",
              {.anchor = "card-{line}-{at}",
               .heading = "{name}",
               .back = {.target = "#top", .text = "of {/views}"},
               .facts = {{{"PSNR", "{db:.1f}"}}, {{"ms", "{ms:.1f}"}}}},
              {"<img alt=\"1\"/>", "", "<img alt=\"3\"/>"});
  EXPECT_THAT(html(), HasSubstr("id=\"card-z0-0\""));
  EXPECT_THAT(html(), HasSubstr("<span>&lt;odd&gt;</span>\n<a href=\"#top\">of 2</a>"));
  EXPECT_THAT(html(), HasSubstr("<img alt=\"3\"/>"));
  EXPECT_THAT(html(), HasSubstr("<dt>ms</dt>\n<dd>–</dd>"));
}

std::size_t count_of(std::string_view what, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string_view::npos; ++at) ++count;
  return count;
}

TEST_F(JsonPageTest, APlotHasASeriesForEachName) {
  const auto plot = [&](const JsonSeries& series) {
    return page_.plot({.title = "Of {room}", .x_label = "at", .y_label = "dB"}, {series},
                      "{views:counted view}");
  };
  const HtmlFigure figure = plot({"scores", "line {line}", "at", "db", PlotStyle::kPoints});
  EXPECT_EQ(figure.caption, "2 views");
  EXPECT_THAT(figure.markup, HasSubstr("Of &lt;white&gt;.lf"));
  EXPECT_EQ(count_of("line x0", figure.markup), 1U);
  EXPECT_EQ(count_of("line z0", figure.markup), 1U);
  // A point for each entry; one that is not measured is left out.
  const std::string all = plot({"scores", "", "at", "db", PlotStyle::kPoints}).markup;
  const std::string measured = plot({"scores", "", "at", "ms", PlotStyle::kPoints}).markup;
  EXPECT_EQ(count_of("<circle", all), 3U);
  EXPECT_EQ(count_of("<circle", measured), 2U);
  page_.figures({figure, {}});
  EXPECT_EQ(count_of("<figure>", html()), 1U);
}

TEST_F(JsonPageTest, WhatTheDocumentLacksIsAnErrorOfTheProgram) {
  EXPECT_THROW(JsonPage(document_, "{rooms}"), std::logic_error);
  EXPECT_THROW(page_.paragraph("{rooms}"), std::logic_error);
  EXPECT_THROW((void)page_.within("rooms"), std::logic_error);
  EXPECT_THROW(page_.table("rooms", {{"a", "{b}"}}), std::logic_error);
  EXPECT_THROW(page_.table("scores", {{"a", "{name}", "rooms"}}), std::logic_error);
  EXPECT_THROW(page_.plot({}, {{"scores", "", "name", "db"}}, ""), std::logic_error);
}

}  // namespace
}  // namespace raywalk
