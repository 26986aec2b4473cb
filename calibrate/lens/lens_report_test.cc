#include "calibrate/lens/lens_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/lens/lens_test_camera.h"
#include "calibrate/lens/lens_values.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
  const nlohmann::ordered_json json = lens_document(fit);
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

std::string page_of(const LensFit& fit) {
  return lens_page(lens_document(fit), residual_figures(fit));
}

TEST(LensReportTest, PageIsWellFormedAndShowsWarnings) {
  LensFit fit = fit_with_residuals();
  EXPECT_THAT(page_of(fit), HasSubstr("No warnings"));
  fit.warnings = {"too <few> points"};
  const std::string page = page_of(fit);
  EXPECT_EQ(markup_fault(page), "");
  EXPECT_THAT(page, AllOf(HasSubstr("too &lt;few&gt; points"), Not(HasSubstr("No warnings"))));
  EXPECT_THAT(page_of(LensFit{}), HasSubstr("</html>"));
}

TEST(LensReportTest, PageShowsTheFit) {
  LensFit fit = fit_with_residuals();
  fit.sigma.back.rim_px = 0.1234;
  const std::string row =
      fmt::format("focal length / px</th><td>{:.2f}</td><td>{:.2f}</td><td>0.020</td>",
                  fit.start.layout.front.focal_px, fit.camera.layout.front.focal_px);
  EXPECT_THAT(page_of(fit),
              AllOf(HasSubstr("from features tracked along the rail"), HasSubstr(row),
                    HasSubstr("0.123 px</dd>"), HasSubstr("0.123 px for the back lens"),
                    HasSubstr("yaw / deg</th><td>180.000</td><td>180.400</td>"
                              "<td>not fitted</td>"),
                    HasSubstr("forwards / mm</th><td>0.00</td><td>-10.00</td>"),
                    HasSubstr("they move with the camera</dt>\n<dd>17</dd>"),
                    HasSubstr("front: mean outwards"), HasSubstr("Back lens</figcaption>")));
  fit.method = "charuco";
  EXPECT_THAT(page_of(fit),
              AllOf(HasSubstr("from pictures of a ChArUco board"),
                    HasSubstr("board corners, once per picture"), Not(HasSubstr("move with the"))));
}

}  // namespace
}  // namespace raywalk::calibrate
