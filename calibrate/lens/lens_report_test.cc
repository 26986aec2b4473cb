#include "calibrate/lens/lens_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/lens/lens_test_camera.h"
#include "calibrate/lens/lens_values.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

// Residuals that point outwards by 0.5 px in a ring of the front lens.
LensFit fit_with_residuals() {
  LensFit fit;
  fit.start = plain_camera({1120, 560});
  fit.camera = true_camera({1120, 560});
  fit.method = "capture";
  fit.sigma.front.focal_px = 0.02;
  fit.dropped_still = 17;
  const FisheyeLens& lens = fit.camera.layout.front;
  for (int i = 0; i < 12; ++i) {
    const double around_rad = kTwoPi * i / 12;
    const double off_axis_rad = radians_from_degrees(62.0);
    const PixelPosition seen = *project(lens, at_angle(off_axis_rad, around_rad));
    fit.residuals.push_back(
        {false, seen, 0.5 * std::cos(around_rad), -0.5 * std::sin(around_rad), off_axis_rad});
  }
  fit.observations = 12;
  return fit;
}

TEST(LensReportTest, RingsShowErrorsOfTheRadialModel) {
  const std::vector<ResidualRing> rings = residual_rings(fit_with_residuals());
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(degrees_from_radians(rings[0].off_axis_rad), 62.5, 1e-9);
  EXPECT_EQ(rings[0].count, 12);
  EXPECT_NEAR(rings[0].rms_px, 0.5, 1e-9);
  EXPECT_NEAR(rings[0].radial_px, 0.5, 1e-9);
}

TEST(LensReportTest, JsonHoldsStartAndFittedValues) {
  const LensFit fit = fit_with_residuals();
  const auto json = nlohmann::json::parse(lens_json(fit));
  EXPECT_EQ(json["front"]["focal_px"]["start"], fit.start.layout.front.focal_px);
  EXPECT_EQ(json["front"]["focal_px"]["fitted"], fit.camera.layout.front.focal_px);
  EXPECT_EQ(json["front"]["focal_px"]["sigma"], 0.02);
  EXPECT_TRUE(json["front"]["largest_angle_deg"]["sigma"].is_null());
  // 180.4 and -179.6 degrees are the same yaw: the one nearer to the start's is reported.
  EXPECT_NEAR(json["back"]["yaw_deg"]["fitted"], 180.4, 1e-9);
  EXPECT_NEAR(json["baseline_mm"]["z"]["fitted"], -10.0, 1e-9);
  EXPECT_EQ(json["dropped_still"], 17);
  EXPECT_TRUE(json["trustworthy"]);
}

TEST(LensReportTest, PageIsWellFormedAndShowsWarnings) {
  LensFit fit = fit_with_residuals();
  EXPECT_THAT(lens_page(fit), HasSubstr("No warnings"));
  fit.warnings = {"too <few> points"};
  const std::string page = lens_page(fit);
  EXPECT_EQ(markup_fault(page), "");
  EXPECT_THAT(page, HasSubstr("too &lt;few&gt; points"));
  EXPECT_THAT(lens_page(LensFit{}), HasSubstr("</html>"));
}

}  // namespace
}  // namespace raywalk::calibrate
