#include "calibrate/rectify/rectify_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

// Two stations, and a held-out frame that no pair of frames compares.
class RectifyReportTest : public ::testing::Test {
 protected:
  RectifyReportTest() {
    set_.source = "hall";
    set_.lines = {{.id = "x0", .frames = {0, 1}}, {.id = "z0", .axis = LineAxis::kZ}};
    set_.frames = {{.name = "a", .nominal_m = {0.25, 0, 0}},
                   {.name = "b", .nominal_m = {0.5, 0, 0}},
                   {.name = "held", .line = kHeldOut}};
    for (int i = 0; i < 3; ++i) poses_.emplace_back(FramePose{});
  }
  nlohmann::ordered_json document() const {
    return rectify_document(set_, poses_, result_, out_.path());
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
  RectifyResult result_{.frames = 2,
                        .validation_frames = 1,
                        .gains = {{1, 1, 1}, {0.92593, 0.92593, 0.92593}, {1, 1, 1}}};
};

TEST_F(RectifyReportTest, SaysWhatIsNextAndWhatThereIsNot) {
  result_.line_tolerance_mm = 4.5;
  const auto document = this->document();
  EXPECT_EQ(document["pack_command"], "raywalk-build-lf pack --frames " +
                                          (out_ / "poses.csv").string() +
                                          " --out ROOM.lf --line-tolerance-mm 4.5");
  EXPECT_EQ(document["before_list"], (out_ / "before.csv").string());
  EXPECT_TRUE(document["frame_masks"].is_null() && document["exposure"].is_null());
  EXPECT_TRUE(document["left_out"].empty() && document["figures"].empty());
}

TEST_F(RectifyReportTest, HasMasksAndFramesLeftOut) {
  result_.masks = {.frames = 17, .share = 0.1234};
  result_.left_out = {"b", "c"};
  EXPECT_EQ(document()["frame_masks"]["frames"], 17);
  EXPECT_EQ(document()["frame_masks"]["masked_share"], 0.1234);
  EXPECT_EQ(document()["left_out"].size(), 2U);
}

TEST_F(RectifyReportTest, NamesOverlays) {
  result_.crossings = {{.along_z = 1,
                        .frame_x = "a",
                        .frame_z = "c",
                        .before = "before.png",
                        .after = "after.png",
                        .difference_before = 12.345,
                        .difference_after = 2.5}};
  const auto document = this->document();
  EXPECT_EQ(document["crossings"][0]["difference_after"], 2.5);
  const auto& figures = document["figures"];
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_EQ(figures[0]["row"], "x0 × z0, frames a and c");
  EXPECT_EQ(figures[0]["file"], "before.png");
  EXPECT_EQ(figures[1]["row"], figures[0]["row"]);
  EXPECT_EQ(figures[1]["caption"], "after: differ by 2.50 levels RMS");
}

TEST_F(RectifyReportTest, TellsHowExposuresWereMeasured) {
  result_.exposure = brighter();
  const auto document = this->document();
  const auto& exposure = document["exposure"];
  EXPECT_EQ(exposure["summary"],
            "exposures or colours differ; 1 of 2 frames are corrected, by at most 0.111 stops");
  EXPECT_EQ(exposure["patches"], 1234);
  EXPECT_EQ(exposure["loop_error"], 0.0031);
  const auto& kind = exposure["kinds"][0];
  EXPECT_EQ(kind["model_text"], "one value per frame");
  EXPECT_EQ(kind["spread"], 0.0789);
  EXPECT_EQ(kind["tests"][0]["largest_t"], 12.34);
  EXPECT_EQ(kind["tests"][0]["frame"], "b");
  EXPECT_EQ(kind["tests"][0]["rejected"], true);
  EXPECT_EQ(kind["halves"][0]["by_chance"], 0.0045);
  const auto& brightness = document["frames"][1]["exposure"]["brightness"];
  EXPECT_NEAR(brightness["measured_change"].get<double>(), 0.08, 1e-9);
  EXPECT_EQ(brightness["error"], 0.0066);
  EXPECT_EQ(brightness["corrected"], true);
  // No pair compares the held-out frame.
  EXPECT_TRUE(document["frames"][2]["exposure"]["brightness"]["measured"].is_null());
}

}  // namespace
}  // namespace raywalk::calibrate
