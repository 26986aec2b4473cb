#include "core/report/html_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/report/markup_check.h"
#include "core/report/svg_plot.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::Not;

cv::Mat gradient() {
  cv::Mat image(16, 32, CV_8UC3);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      image.at<cv::Vec3b>(row, column) = cv::Vec3b(static_cast<unsigned char>(row * 8),
                                                   static_cast<unsigned char>(column * 4), 100);
    }
  }
  return image;
}

// The bytes of a data URI, decoded independently of the encoder under test.
std::vector<unsigned char> decoded(const std::string& uri) {
  static const std::string alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : uri.substr(uri.find(',') + 1)) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(alphabet.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> count));
  }
  return bytes;
}

TEST(DataUri, IsBase64OfTheBytes) {
  const std::string text = "light field";
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  EXPECT_EQ(data_uri(std::span(bytes, 11), "text/plain"),
            "data:text/plain;base64,bGlnaHQgZmllbGQ=");
  EXPECT_EQ(data_uri(std::span(bytes, 10), "a/b"), "data:a/b;base64,bGlnaHQgZmllbA==");
  EXPECT_EQ(data_uri(std::span(bytes, 9), "a/b"), "data:a/b;base64,bGlnaHQgZmll");
  EXPECT_EQ(data_uri(std::span(bytes, 0), "a/b"), "data:a/b;base64,");
}

TEST(DataUri, HoldsMoreThanOneBlock) {
  std::vector<unsigned char> bytes(7'000'001);
  std::iota(bytes.begin(), bytes.end(), static_cast<unsigned char>(0));
  EXPECT_EQ(decoded(data_uri(bytes, "a/b")), bytes);
}

TEST(DataUri, PngKeepsEveryPixel) {
  const std::string uri = data_uri(gradient(), EmbeddedFormat::kPng);
  EXPECT_THAT(uri, testing::StartsWith("data:image/png;base64,"));
  const cv::Mat back = cv::imdecode(decoded(uri), cv::IMREAD_COLOR);
  EXPECT_EQ(cv::norm(back, gradient(), cv::NORM_INF), 0.0);
}

TEST(DataUri, JpegComesClose) {
  const std::string uri = data_uri(gradient(), EmbeddedFormat::kJpeg);
  EXPECT_THAT(uri, testing::StartsWith("data:image/jpeg;base64,"));
  const cv::Mat back = cv::imdecode(decoded(uri), cv::IMREAD_COLOR);
  EXPECT_LT(cv::norm(back, gradient(), cv::NORM_INF), 24.0);
}

TEST(DataUri, RejectsInvalidImages) {
  EXPECT_THROW(data_uri(cv::Mat(), EmbeddedFormat::kPng), Error);
  EXPECT_THROW(data_uri(cv::Mat(4, 4, CV_32FC3), EmbeddedFormat::kPng), Error);
}

HtmlPage full_page() {
  HtmlPage page("A title", "A subtitle");
  page.add_facts({{"PSNR", "34.2 dB"}});
  page.add_section("A section");
  page.add_paragraph("A paragraph.");
  page.add_table({.caption = "A table",
                  .header = {"method", "error"},
                  .rows = {{{"initial"}, {"731"}}, {{"hlf-vd"}, {"45", true}}}});
  page.add_figures({svg_figure(svg_from_plot({.title = "A plot"}), "A plot's caption"),
                    picture_figure(gradient(), EmbeddedFormat::kPng, "A gradient", "A picture")});
  return page;
}

TEST(HtmlPage, IsWellFormed) {
  EXPECT_EQ(markup_fault(full_page().html()), "");
  EXPECT_EQ(markup_fault(HtmlPage("").html()), "");
}

TEST(HtmlPage, IsSelfContained) {
  const std::string html = full_page().html();
  for (const char* part : {"<link", "<script", "src=\"http", "url(", "@import"}) {
    EXPECT_THAT(html, Not(HasSubstr(part)));
  }
}

TEST(HtmlPage, KeepsTheOrderOfItsContent) {
  const std::string html = full_page().html();
  std::size_t at = html.find("<h1>");
  for (const char* part : {"A title", "A subtitle", "34.2 dB", "A section", "A paragraph.",
                           "A table", "731", "A plot's caption", "A picture"}) {
    const std::string text =
        std::string(part) == "A plot's caption" ? "A plot&#39;s caption" : part;
    at = html.find(text, at);
    ASSERT_NE(at, std::string::npos) << part;
  }
}

TEST(HtmlPage, EscapesEveryText) {
  const std::string evil = "<script>\"&";
  HtmlPage page(evil, evil);
  page.add_facts({{evil, evil}});
  page.add_section(evil);
  page.add_paragraph(evil);
  page.add_table({.caption = evil, .header = {evil}, .rows = {{{evil}}, {{evil, true}}}});
  page.add_figures(
      {svg_figure("<svg/>", evil), picture_figure(gradient(), EmbeddedFormat::kPng, evil, evil)});
  const std::string html = page.html();
  EXPECT_EQ(markup_fault(html), "");
  EXPECT_THAT(html, Not(HasSubstr("<script>")));
}

TEST(HtmlPage, EmphasisesACell) {
  const std::string html = full_page().html();
  EXPECT_THAT(html, HasSubstr("<td class=\"best\">45</td>"));
  EXPECT_THAT(html, HasSubstr("<td>731</td>"));
}

TEST(HtmlPage, RejectsARowOfAnotherLength) {
  HtmlPage page("A title");
  EXPECT_THROW(page.add_table({.caption = "t", .header = {"a", "b"}, .rows = {{{"1"}}}}), Error);
  EXPECT_THAT(page.html(), Not(HasSubstr("<table>")));
}

// What lies within the innermost <div class="scroll"> of a page with one table.
std::string scrolling_part(const std::string& html) {
  const std::size_t begin = html.find("<div class=\"scroll\"");
  return html.substr(begin, html.find("</div>", begin) - begin);
}

TEST(HtmlPage, AWideTableScrollsByItselfAndItsCaptionDoesNot) {
  HtmlPage page("A title");
  HtmlTable table{.caption = "A caption that is longer than a phone is wide"};
  for (int column = 0; column < 40; ++column) table.header.push_back("a long heading");
  table.rows.emplace_back(40, HtmlCell{"0.123456"});
  page.add_table(table);
  const std::string html = page.html();
  EXPECT_EQ(markup_fault(html), "");
  EXPECT_THAT(scrolling_part(html), HasSubstr("<td>0.123456</td>"));
  EXPECT_THAT(scrolling_part(html), Not(HasSubstr(">A caption")));
  EXPECT_THAT(html, HasSubstr("<p>A caption that is longer"));
  EXPECT_THAT(html, Not(HasSubstr("<caption>")));
}

TEST(HtmlPage, LongWordsBreakInsteadOfWideningThePage) {
  EXPECT_THAT(HtmlPage("/a/path/without/a/place/to/break").html(),
              HasSubstr("h1, h2, p, li, dd, figcaption { overflow-wrap: anywhere; }"));
}

// So that browsers repeat it on every page that a long table is printed on.
TEST(HtmlPage, TheHeaderOfATableIsNoRowOfItsBody) {
  EXPECT_THAT(full_page().html(),
              HasSubstr("<thead><tr><th scope=\"col\">method</th><th scope=\"col\">error</th></tr>"
                        "</thead>\n<tbody>\n<tr><th scope=\"row\">initial</th>"));
}

std::string page_of(std::size_t pictures, std::size_t drawings) {
  std::vector<HtmlFigure> figures(
      pictures, picture_figure(gradient(), EmbeddedFormat::kPng, "A gradient", "A picture"));
  figures.insert(figures.end(), drawings, svg_figure("<svg/>", "A drawing"));
  HtmlPage page("A title");
  page.add_figures(figures);
  return page.html();
}

TEST(HtmlPage, FiguresStandInColumnsThatLeaveNoGap) {
  EXPECT_THAT(page_of(3, 0), HasSubstr("<div class=\"figures three\">"));
  EXPECT_THAT(page_of(9, 0), HasSubstr("<div class=\"figures three\">"));
  for (const auto& [pictures, drawings] :
       {std::pair{2U, 0U}, {4U, 0U}, {6U, 0U}, {5U, 0U}, {0U, 3U}, {2U, 1U}}) {
    EXPECT_THAT(page_of(pictures, drawings), HasSubstr("<div class=\"figures two\">"));
  }
  EXPECT_THAT(page_of(1, 0), HasSubstr("<div class=\"figures one\">"));
  // An odd one out takes the whole row.
  EXPECT_THAT(page_of(5, 0),
              HasSubstr(".two > figure:last-child:nth-child(odd) { grid-column: 1 / -1; }"));
}

TEST(HtmlPage, SmallPicturesFillTheirCards) {
  EXPECT_THAT(page_of(2, 0), HasSubstr("figure img { display: block; width: 100%; height: auto;"));
}

TEST(HtmlPage, CardsHaveAnchors) {
  HtmlPage page("Cards");
  page.add_section("Overview & more", "top");
  page.add_table({.header = {"name"}, .rows = {{{.text = "a<b", .link = "#card-1"}}}});
  const std::vector<HtmlCard> cards{
      {.anchor = "card-1",
       .heading = "a<b",
       .back = {.target = "#top", .text = "back"},
       .picture = picture_figure(gradient(), EmbeddedFormat::kPng, "a", "").markup,
       .facts = {{{"width", "32 px"}}, {{"time", "<1 ms"}}}},
      {.anchor = "card-2", .heading = "empty"}};
  page.add_cards(cards);
  const std::string html = page.html();
  EXPECT_EQ(markup_fault(html), "");
  EXPECT_THAT(html, HasSubstr("<h2 id=\"top\">Overview &amp; more</h2>"));
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\"><a href=\"#card-1\">a&lt;b</a></th>"));
  EXPECT_THAT(html, HasSubstr("id=\"card-1\""));
  EXPECT_THAT(html, HasSubstr("<a href=\"#top\">back</a>"));
  EXPECT_THAT(html, HasSubstr("<dd>&lt;1 ms</dd>"));
  EXPECT_THAT(html, HasSubstr("id=\"card-2\""));
}

}  // namespace
}  // namespace raywalk
