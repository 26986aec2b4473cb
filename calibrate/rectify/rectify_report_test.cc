#include "calibrate/rectify/rectify_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

// Two stations, and a held-out frame.
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
  TestDirectory out_;
  CaptureSet set_{};
  FramePoses poses_{};
  RectifyResult result_{
      .files = {"a.jpg", "b.jpg", "held.jpg"}, .frames = 2, .validation_frames = 1};
};

TEST_F(RectifyReportTest, SaysWhatIsNextAndWhatThereIsNot) {
  result_.line_tolerance_mm = 4.5;
  const auto document = this->document();
  EXPECT_EQ(document["pack_command"], "raywalk-build-lf pack --frames " +
                                          (out_ / "poses.csv").string() +
                                          " --out ROOM.lf --line-tolerance-mm 4.5");
  EXPECT_EQ(document["before_list"], (out_ / "before.csv").string());
  EXPECT_TRUE(document["frame_masks"].is_null());
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

}  // namespace
}  // namespace raywalk::calibrate
