#include "core/report/report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/error.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// What the page reads.
ordered_json content_of(const std::string& page) {
  const std::string before = "id=\"report\">", after = "</script>";
  const std::size_t begin = page.find(before) + before.size();
  return ordered_json::parse(page.substr(begin, page.find(after, begin) - begin));
}

TEST(ReportPageTest, HoldsTheDocumentAndAsksForNothingElse) {
  const ordered_json document{{"psnr_db", 37.5}, {"names", {"a", "b"}}};
  const std::string page = report_page("validation", document);
  EXPECT_EQ(content_of(page)["kind"], "validation");
  EXPECT_EQ(content_of(page)["document"], document);
  EXPECT_THAT(page, ::testing::StartsWith("<!doctype html>"));
  EXPECT_THAT(page, ::testing::Not(::testing::ContainsRegex("(src|href)=\"?(http|/)")));
}

TEST(ReportPageTest, NoTextOfADocumentIsMarkup) {
  const std::string text = "</script><script>alert(1)</script><!-- & \" RAYWALK_REPORT";
  const std::string page = report_page("validation", {{"volume", text}});
  EXPECT_EQ(content_of(page)["document"]["volume"], text);
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr("alert(1)</script>")));
}

TEST(ReportPageTest, WhatJsonCannotSayIsReplaced) {
  const ordered_json content = content_of(
      report_page("validation", {{"value", std::nan("")}, {"file", std::string("a\xFFz")}}));
  EXPECT_TRUE(content["document"]["value"].is_null());
  EXPECT_EQ(content["document"]["file"], "a\uFFFDz");
}

TEST(ReportPageTest, AnImageThatSeveralRowsShowIsWrittenOnce) {
  const cv::Mat black(4, 8, CV_8UC3, cv::Scalar(0, 0, 0)), white(4, 8, CV_8UC1, cv::Scalar(255));
  const std::vector<ReportImage> images{report_image("views", "a", "true", black),
                                        report_image("views", "a", "rendered", white),
                                        report_image("views", "b", "true", black)};
  const ordered_json content = content_of(report_page("validation", {}, images));
  ASSERT_EQ(content["images"].size(), 3U);
  EXPECT_EQ(content["images"][2]["row"], "b");
  EXPECT_EQ(content["images"][2]["source"], content["images"][0]["source"]);
  ASSERT_EQ(content["sources"].size(), 2U);
  EXPECT_THAT(content["sources"][1].get<std::string>(),
              ::testing::StartsWith("data:image/jpeg;base64,/9j/"));
}

TEST(ReportImageTest, OtherTypesAreRefused) {
  EXPECT_THROW(report_image("views", "a", "b", cv::Mat()), Error);
  EXPECT_THROW(report_image("views", "a", "b", cv::Mat(2, 2, CV_16UC1)), Error);
}

}  // namespace
}  // namespace raywalk
