#include "capture/plan/quality_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<MeasuredRoom>& curves() {
  static const std::vector<MeasuredRoom> rooms{{"a", {{0.1, 37, 34}, {0.2, 36, 33}, {0.4, 33, 30}}},
                                               {"b", {{0.2, 32, 31}, {0.4, 31, 29}}}};
  return rooms;
}

std::string text_at(double spacing_mm) {
  return quality_text(quality_report(spacing_mm, 1.0, curves()));
}

TEST(QualityReportTest, QuotesWhatOtherRoomsHadAndNamesTheSource) {
  EXPECT_THAT(text_at(200.0),
              AllOf(HasSubstr("quality:   the stations are 0.2 of the distance"),
                    HasSubstr("2 rooms captured like this"),
                    HasSubstr("two-sided views of 32.0 to 36.0 dB, the worst 31.0\n"),
                    HasSubstr("twice the spacing lost 1.0 to 3.0 dB, half of it gained 1.0 dB; "
                              "docs/spacing.md has the measured rooms; yours may differ\n")));
}

TEST(QualityReportTest, SaysWhenNothingWasMeasured) {
  EXPECT_THAT(text_at(50.0), HasSubstr("denser than any room that was measured (from 0.100 on)"));
  EXPECT_THAT(text_at(500.0), HasSubstr("sparser than any room that was measured (up to 0.40)"));
  EXPECT_THAT(quality_text(quality_report(50.0, 0.0, curves())),
              HasSubstr("set scene.nearest_m to compare"));
}

TEST(QualityReportTest, JsonHoldsTheSame) {
  const nlohmann::json json = quality_json(quality_report(200.0, 1.0, curves()));
  EXPECT_EQ(json["rooms"], 2);
  EXPECT_NEAR(json["two_sided_db"]["least"].get<double>(), 32.0, 1e-9);
  EXPECT_NEAR(json["lost_by_twice_db"]["most"].get<double>(), 3.0, 1e-9);
  EXPECT_TRUE(quality_json(quality_report(50.0, 1.0, curves()))["two_sided_db"].is_null());
  EXPECT_TRUE(quality_json(std::nullopt).is_null());
}

}  // namespace
}  // namespace raywalk::capture
