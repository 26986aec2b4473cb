#include "build_lf/depth/depth_page.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/depth_test_room.h"
#include "core/report/markup_check.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class DepthPageTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec tiny = room_of_scale(1.0);
    tiny.width = 32;
    return tiny;
  }
  std::string page() const {
    return depth_page(depth_document(summary_), map_pictures(room_.room(), shown_));
  }

  DepthTestRoom room_{spec()};
  DepthSummary summary_{.room = "room.lf",
                        .method = "sweep",
                        .size = {32, 16},
                        .stations = 68,
                        .reach_m = 0.5,
                        .maps = {{"x0", 0, "a.png", 0.5, 0.1}, {"x0", 8, "b.png", 0.6, 0.1}}};
  std::vector<InverseDistanceMap> shown_{true_map(spec().scene, {0, 0, -0.5}, {32, 16})};
};

size_t count_of(const std::string& what, const std::string& text) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++count;
  return count;
}

TEST_F(DepthPageTest, ShowsAPictureOfEveryMap) {
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_EQ(count_of("data:image/jpeg", page()), 3U);
  EXPECT_THAT(page(), HasSubstr("line x0, station 0"));
  shown_.push_back(shown_.front());
  EXPECT_EQ(count_of("data:image/jpeg", page()), 6U);
  EXPECT_THAT(page(), Not(HasSubstr("Warnings")));
  EXPECT_THAT(page(), Not(HasSubstr("Comparison with the given distances")));
}

TEST_F(DepthPageTest, SaysHowMuchHasLowConfidenceAndWhatViewsUse) {
  summary_.distances = "estimated by sweep";
  EXPECT_THAT(page(), HasSubstr("confidence below 0.25"));
  EXPECT_THAT(page(), HasSubstr("10.0 %"));
  EXPECT_THAT(page(), HasSubstr("estimated by sweep"));
}

TEST_F(DepthPageTest, EscapesFileNamesInWarnings) {
  summary_.room = "<R&D> \"room\".lf";
  summary_.warnings = {"<b>&.png is a copy of \"a\".png", "line x1 is 0.1 m long"};
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_THAT(page(), HasSubstr("&lt;b&gt;&amp;.png is a copy of"));
  EXPECT_THAT(page(), HasSubstr("line x1 is 0.1 m long"));
}

TEST_F(DepthPageTest, ShowsTheTruthIfCompared) {
  summary_.truth =
      TruthComparison{2, 0.512, 0.75, 0.875, 0.02, {{0.0625, 1234, 0.9, 2.5}, {0.9, 99, 0.1, 0.2}}};
  EXPECT_EQ(markup_fault(page()), "");
  for (const char* figure : {"51.2 %", "75.0 %", "87.5 %", "2.00 %", "1234", "90.0 %", "2.50"}) {
    EXPECT_THAT(page(), HasSubstr(figure));
  }
  EXPECT_THAT(page(), Not(HasSubstr("Beside silhouettes")));
}

TEST_F(DepthPageTest, ShowsTheErrorsBesideSilhouettesByThemselves) {
  summary_.truth = TruthComparison{
      2, 0.512, 0.75, 0.875, 0.02, {{0.3, 5678, 0.9, 2.5}}, {{0.3, 432, 0.35, 1.5}}};
  EXPECT_EQ(markup_fault(page()), "");
  for (const char* text : {"beside silhouettes", "432", "35.0 %", "1.50", "5678", "90.0 %"}) {
    EXPECT_THAT(page(), HasSubstr(text));
  }
}

TEST_F(DepthPageTest, SaysWhatWasLeftOutAndWhatGainsDo) {
  EXPECT_THAT(page(), AllOf(Not(HasSubstr("not looked for")), Not(HasSubstr("<h2>Left out</h2>")),
                            Not(HasSubstr("<h2>Gains</h2>"))));
  summary_.left_out = {{"x0", 8, "b.png", 0.034}};
  summary_.gains = GainsSummary{.stations = 68, .corrected = 17, .spread = 0.05, .largest = 1.25};
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_THAT(page(), AllOf(HasSubstr("<h2>Left out</h2>"), HasSubstr("3.40 %"),
                            HasSubstr("0.05 %"), HasSubstr("17 of 68 stations")));
  summary_.leave_out_moving = false;
  EXPECT_THAT(page(), HasSubstr("not looked for"));
}

TEST_F(DepthPageTest, HandlesARoomOfSky) {
  for (float& omega : shown_.front().omega) omega = 0.0f;
  for (std::uint8_t& confidence : shown_.front().confidence) confidence = 0;
  EXPECT_EQ(markup_fault(page()), "");
  shown_.clear();
  summary_.maps.clear();
  EXPECT_EQ(markup_fault(page()), "");
}

}  // namespace
}  // namespace raywalk::build_lf
