#include "calibrate/lens/calibrate_lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "calibrate/lens/lens_test_camera.h"
#include "core/base/test_error.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CalibrateLensTest : public ::testing::Test {
 protected:
  CalibrateLensTest() {
    write_lens_file(options_.start, plain_camera({640, 320}));
    set_.lines = {{"x0", LineAxis::kX, 0.0, false, {0}}};
    set_.frames.emplace_back();
  }
  std::string complaint() const {
    return error_of([&] { calibrate_lens(set_, options_); });
  }

  TestDirectory directory_;
  CaptureSet set_{.source = "somewhere", .layout = FrameLayout::kDualFisheye, .frame = {640, 320}};
  LensOptions options_{.start = directory_ / "start.yaml", .out = directory_ / "out"};
};

TEST_F(CalibrateLensTest, PanoramasAndStartsOfOtherCamerasAreRefused) {
  set_.layout = FrameLayout::kPanorama;
  EXPECT_THAT(complaint(), AllOf(HasSubstr("somewhere"), HasSubstr("panoramas already")));
  EXPECT_EQ(directory_.entries(), 1U);  // nothing written
  set_.layout = FrameLayout::kDualFisheye;
  set_.frame = {640, 360};
  EXPECT_THAT(complaint(), HasSubstr("another aspect ratio"));
  set_.frame = {640, 320};
  set_.frames.front().back = "back.jpg";
  EXPECT_THAT(complaint(), AllOf(HasSubstr("start.yaml"), HasSubstr("one file")));
  options_.start = directory_ / "none.yaml";
  EXPECT_THAT(complaint(), HasSubstr("none.yaml"));
}

TEST_F(CalibrateLensTest, InvalidOptionsAreUsageErrors) {
  options_.pairs = 5;
  EXPECT_THROW(calibrate_lens(set_, options_), UsageError);
  options_.pairs = 24;
  for (const double cone_deg : {-1.0, 90.0, std::nan("")}) {
    options_.ignore_below_deg = cone_deg;
    EXPECT_THROW(calibrate_lens(set_, options_), UsageError) << cone_deg;
  }
}

// Residuals that point outwards by 0.5 px in a ring of the front lens.
LensFit fit_with_residuals() {
  LensFit fit;
  fit.start = plain_camera({1120, 560});
  fit.camera = true_camera({1120, 560});
  fit.sigma.front.focal_px = 0.02;
  fit.dropped_still = 17;
  const FisheyeLens& lens = fit.camera.layout.front;
  for (int i = 0; i < 12; ++i) {
    const double around_rad = kTwoPi * i / 12;
    const double off_axis_rad = radians_from_degrees(62.0);
    const PixelPosition seen = *project(lens, at_angle(off_axis_rad, around_rad));
    fit.residuals.push_back({false, seen, 0.5 * std::cos(around_rad), -0.5 * std::sin(around_rad)});
  }
  fit.observations = 12;
  return fit;
}

TEST(LensReportTest, JsonHoldsStartFittedValuesAndErrorsOfTheRadialModel) {
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
  const auto& rings = json["residuals_over_angle"];
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0]["off_axis_deg"], 62.5, 1e-9);
  EXPECT_EQ(rings[0]["count"], 12);
  EXPECT_NEAR(rings[0]["rms_px"], 0.5, 1e-9);
  EXPECT_NEAR(rings[0]["radial_px"], 0.5, 1e-9);
}

TEST(LensReportTest, FiguresShowTheResidualsOfEachLens) {
  const TestDirectory out;
  const nlohmann::ordered_json figures = residual_figures(fit_with_residuals(), out.path());
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_THAT(figures[0]["caption"], testing::StartsWith("front lens: 12 image points"));
  const auto ink = [&](int lens) {
    const cv::Mat image = read_picture(out / figures[lens]["file"].get<std::string>());
    return cv::norm(image, cv::Mat(image.size(), CV_8UC3, cv::Scalar(255, 255, 255)), cv::NORM_L1);
  };
  EXPECT_GT(ink(0), 1.05 * ink(1));  // both have a rim
  EXPECT_EQ(residual_figures(LensFit{}, out.path()).size(), 2U);
}

}  // namespace
}  // namespace raywalk::calibrate
