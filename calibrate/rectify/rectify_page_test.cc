#include "calibrate/rectify/rectify_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "calibrate/rectify/rectify_report.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Two stations, and a held-out frame that no pair of frames compares.
class RectifyPageTest : public ::testing::Test {
 protected:
  RectifyPageTest() {
    set_.source = "hall & {garden}";
    set_.lines = {{.id = "x0", .frames = {0, 1}}, {.id = "z0", .axis = LineAxis::kZ}};
    set_.frames = {{.name = "a", .nominal_m = {0.25, 0, 0}},
                   {.name = "b", .nominal_m = {0.5, 0, 0}},
                   {.name = "held", .line = kHeldOut}};
    for (int i = 0; i < 3; ++i) poses_.emplace_back(FramePose{});
  }
  nlohmann::ordered_json document() const {
    return rectify_document(set_, poses_, grid_ ? &*grid_ : nullptr, result_, out_.path());
  }
  std::string page() const {
    const auto written = document();
    const std::string page = rectify_page(written, out_.path());
    EXPECT_EQ(markup_fault(page), "");
    return page;
  }
  // The second station is 8 % brighter, by a test that contradicts equal exposures.
  static ExposureResult brighter() {
    ExposureResult exposure{.gains = {{1, 1, 1}, {0.92593, 0.92593, 0.92593}, {1, 1, 1}},
                            .measured = {true, true, false},
                            .links = 7,
                            .patches = 1234,
                            .scene_parts = 19,
                            .loops = 5,
                            .loop_error = 0.0031};
    for (MeasuredLight& light : exposure.light) {
      for (Eigen::VectorXd* values : {&light.decision.measured, &light.decision.fitted,
                                      &light.decision.error, &light.decision.correction}) {
        *values = Eigen::VectorXd::Zero(3);
      }
      light.decision.tests = {{ExposureModel::kEqual, 12.34, 1, true}};
      light.decision.model = ExposureModel::kStations;
      light.decision.t_limit = 4.56;
      light.halves = {{"match quality", 0.0123, 0.0045}};
      light.spread = 0.0789;
    }
    ExposureDecision& brightness = exposure.light[0].decision;
    brightness.measured[1] = brightness.fitted[1] = std::log(1.08);
    brightness.error[1] = 0.0066;
    brightness.correction[1] = std::log(1.08);
    return exposure;
  }

  TestDirectory out_;
  CaptureSet set_{};
  FramePoses poses_{};
  std::optional<GridResult> grid_{};
  RectifyResult result_{.frames = 2,
                        .validation_frames = 1,
                        .gains = {{1, 1, 1}, {0.92593, 0.92593, 0.92593}, {1, 1, 1}}};
};

TEST_F(RectifyPageTest, SaysWhatIsNextAndLeavesOutWhatThereIsNot) {
  const std::string page = this->page();
  EXPECT_THAT(page, AllOf(HasSubstr("hall &amp; {garden}"),
                          HasSubstr("raywalk-build-lf pack --frames " +
                                    (out_ / "poses.csv").string() + " --out ROOM.lf</p>"),
                          HasSubstr((out_ / "before.csv").string()), HasSubstr("--no-gain")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("mask of their own")), Not(HasSubstr("Omitted")),
                          Not(HasSubstr("At the crossings")), Not(HasSubstr("Overlays"))));
}

TEST_F(RectifyPageTest, ShowsMasksFramesLeftOutAndCrossings) {
  result_.masks = {.frames = 17, .share = 0.1234};
  result_.left_out = {"b", "c <d>"};
  result_.line_tolerance_mm = 4.5;
  grid_ = GridResult{.crossings = {{.along_z = 1, .sigma_mm = 6.78, .sigma_px = 0.91}}};
  grid_->crossings[0].before.median_px = 5.55;
  EXPECT_THAT(page(), AllOf(HasSubstr("12.34 %"), HasSubstr("<dd>17</dd>"),
                            HasSubstr("Omitted, without a pose: b, c &lt;d&gt;."),
                            HasSubstr("--line-tolerance-mm 4.5"), HasSubstr("x0 × z0"),
                            HasSubstr("6.78"), HasSubstr("0.91"), HasSubstr("5.55 →")));
}

TEST_F(RectifyPageTest, ShowsOverlays) {
  for (const char* name : {"before.png", "after.png"}) {
    write_image(out_ / name, cv::Mat(8, 16, CV_8UC3, cv::Scalar(90, 90, 90)));
  }
  result_.crossings = {{.along_z = 1,
                        .frame_x = "a",
                        .frame_z = "c",
                        .before = "before.png",
                        .after = "after.png",
                        .difference_before = 12.345,
                        .difference_after = 2.5}};
  EXPECT_THAT(page(),
              AllOf(HasSubstr("x0 × z0, frames a and c, before: differ by 12.35 levels RMS"),
                    HasSubstr("x0 × z0, frames a and c, after: differ by 2.50 levels RMS")));
}

TEST_F(RectifyPageTest, ShowsHowExposuresWereMeasured) {
  result_.exposure = brighter();
  const std::string page = this->page();
  EXPECT_THAT(page, AllOf(HasSubstr("1 of 2 frames are corrected, by at most 0.111 stops."),
                          HasSubstr("Gain of every frame"), HasSubstr("1234 small surfaces"),
                          HasSubstr("19 of 24 parts"), HasSubstr("5 loops, to 0.31 %"),
                          HasSubstr("less than 1 % of captures")));
  EXPECT_THAT(page, AllOf(HasSubstr("one value per frame"), HasSubstr("7.89 %"),
                          HasSubstr("all frames alike"), HasSubstr("12.3"), HasSubstr("4.6"),
                          HasSubstr("contradicted"), HasSubstr("match quality"),
                          HasSubstr("1.23 %"), HasSubstr("0.45 %")));
  EXPECT_THAT(page, AllOf(HasSubstr("8.00 %"), HasSubstr("0.66 %"), HasSubstr("0.92593")));
}

TEST_F(RectifyPageTest, FramesThatNothingComparesHaveNoExposure) {
  result_.exposure = brighter();
  const auto frames = document()["frames"];
  EXPECT_TRUE(frames[2]["exposure"]["brightness"]["measured"].is_null());
  EXPECT_TRUE(frames[2]["line"].is_null());
  EXPECT_EQ(frames[1]["exposure"]["red"]["measured"], 0.0);
  EXPECT_EQ(frames[1]["line"], "x0");
  EXPECT_EQ(frames[1]["rail_m"], 0.5);
  EXPECT_NEAR(frames[1]["gain_stops"], -0.111, 1e-3);
}

TEST_F(RectifyPageTest, ShowsNoEvidenceWhereNothingCouldBeTested) {
  result_.exposure = brighter();
  result_.exposure->gains = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  for (MeasuredLight& light : result_.exposure->light) light.decision.tests.clear();
  EXPECT_THAT(page(),
              AllOf(HasSubstr("too little of the scene"), Not(HasSubstr("Gain of every frame")),
                    Not(HasSubstr("How it was measured"))));
}

}  // namespace
}  // namespace raywalk::calibrate
