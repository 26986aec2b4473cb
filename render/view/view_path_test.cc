#include "render/view/view_path.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "render/view/view_file.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(ViewFile, ReadsViewpointsOfEitherSign) {
  const Viewpoint viewpoint = viewpoint_from_text("-0.1,2e-1");
  EXPECT_EQ(viewpoint.plan.x_m, -0.1);
  EXPECT_EQ(viewpoint.plan.z_m, 0.2);
  EXPECT_FALSE(viewpoint.height_m);
  const Viewpoint raised = viewpoint_from_text("-0.1, 0.05 2e-1");
  EXPECT_EQ(raised.height_m, 0.05);
  EXPECT_EQ(raised.plan.x_m, -0.1);
  EXPECT_EQ(raised.plan.z_m, 0.2);
  for (const char* text :
       {"", "1", "1,", ",1", "1,2,3,4", "1,2,", "1;2", "nan,0", "0,inf", "a,b"}) {
    EXPECT_THROW(viewpoint_from_text(text), UsageError) << text;
  }
}

TEST(ViewFile, SummarisesAView) {
  const ViewMode mode{.options = {.k_deg = 80.0}, .k_source = "given"};
  const std::string text =
      view_summary(mode, {.limited_corners = 2, .filled_share = 0.016, .empty_share = 0.5});
  EXPECT_THAT(text, AllOf(HasSubstr("hlf-vd, hybrid at k = 80 degrees (given)"),
                          HasSubstr("2 of 4 corners"), HasSubstr("1.6 % filled"),
                          HasSubstr("50.0 % empty")));
  EXPECT_EQ(text.find("seen by no station"), std::string::npos);
}

class ViewPathTest : public ::testing::Test {
 protected:
  ViewPathTest() {
    write_synthetic_room({.width = 32}, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
    list("name,x,z\na,0,0\nb,0.25,-0.25\n");
  }
  void list(const std::string& text) const { std::ofstream(path()) << text; }
  fs::path path() const { return directory_ / "path.csv"; }
  fs::path out() const { return directory_ / "views"; }
  std::string run(double k_deg = 80.0, const ViewFrame& frame = {}) const {
    return write_path(room_, {.options = {.k_deg = k_deg}}, frame, {path()}, format_, out());
  }
  std::string run_error(double k_deg = 80.0, const ViewFrame& frame = {}) const {
    return error_of([&] { run(k_deg, frame); });
  }

  TestDirectory directory_;
  Room room_;
  PictureFormat format_{};
};

TEST_F(ViewPathTest, WritesEveryViewAndItsSettings) {
  EXPECT_THAT(run(), HasSubstr("2 views, 2 of them rendered now"));
  Renderer renderer(room_, {.k_deg = 80.0});
  const cv::Mat expected = renderer.render({0.25, -0.25}).image;
  EXPECT_EQ(cv::norm(read_panorama(out() / "b.png"), expected, cv::NORM_INF), 0.0);
  const auto record = nlohmann::json::parse(read_file(out() / "views.json"));
  EXPECT_EQ(record["method"], "hlf-vd");
  EXPECT_EQ(record["k_deg"], 80.0);
  EXPECT_EQ(record["enlargement"], 1.0);
  EXPECT_EQ(record["views"].size(), 2U);
  EXPECT_EQ(record["distances"], "given");
}

// The room's fingerprint tells whether they have changed.
TEST_F(ViewPathTest, ResumesARecordWithoutTheOriginOfDistances) {
  run();
  auto record = nlohmann::json::parse(read_file(out() / "views.json"));
  record.erase("distances");
  write_file_atomically(out() / "views.json", record.dump());
  EXPECT_THAT(run(), HasSubstr("2 views, 0 of them rendered now"));
}

TEST_F(ViewPathTest, SummariesNameTheDistancesInUse) {
  EXPECT_THAT(run(), HasSubstr("distances given"));
  EXPECT_THAT(
      write_view(room_, {.options = {.k_deg = 80.0}}, {0.0, 0.0}, {}, directory_ / "view.png"),
      HasSubstr("distances given"));
  EXPECT_EQ(distances_used(room_, {.options = {.method = ViewMethod::kInitial}}), "none");
}

TEST_F(ViewPathTest, EnlargedViewsSayByHowMuch) {
  const ViewFrame flat{.fov_deg = 90.0, .size = "1440x1600"};
  const std::string enlarged = fmt::format("{:.0f} times", 720.0 * kTwoPi / room_.panorama().width);
  EXPECT_THAT(run(80.0, flat), AllOf(HasSubstr("rendered now, enlarged"), HasSubstr(enlarged)));
  auto record = nlohmann::json::parse(read_file(out() / "views.json"));
  EXPECT_DOUBLE_EQ(record["enlargement"], 720.0 * kTwoPi / room_.panorama().width);
  // A record of an earlier version, without it, is still that of the same settings.
  record.erase("enlargement");
  write_file_atomically(out() / "views.json", record.dump());
  EXPECT_THAT(run(80.0, flat), HasSubstr("0 of them rendered now"));
}

TEST_F(ViewPathTest, RendersForTwoEyesAtTheHeightsOfTheTable) {
  list("name,x,y,z,yaw\na,0,0.1,0,90\nb,0.25,-0.2,-0.25,0\n");
  const ViewFrame both{.stereo = Stereo::kOds};
  run(80.0, both);
  Renderer renderer(room_, {.k_deg = 80.0});
  const cv::Mat expected = renderer.render_stereo({{0.25, -0.25}, -0.2}, 0.063).image;
  EXPECT_EQ(cv::norm(read_picture(out() / "b.png"), expected, cv::NORM_INF), 0.0);
  const auto record = nlohmann::json::parse(read_file(out() / "views.json"));
  EXPECT_EQ(record["stereo"], "ods");
  EXPECT_EQ(record["ipd_mm"], 63.0);
  EXPECT_EQ(record["views"][1]["y_m"], -0.2);
  EXPECT_THAT(run_error(80.0, {.stereo = Stereo::kOds, .ipd_mm = 60.0}), HasSubstr("ipd_mm"));
  EXPECT_THAT(run_error(), HasSubstr("another"));
  list("name,x,z,pitch\na,0,0,0\nb,0.25,-0.25,5\n");
  EXPECT_THAT(run_error(80.0, both), AllOf(HasSubstr("view 'b'"), HasSubstr("pitch")));
  list("name,x,z\na,0,0\nb,0.48,0\n");
  EXPECT_THAT(run_error(80.0, both), AllOf(HasSubstr("view 'b'"), HasSubstr("farther inside")));
}

TEST_F(ViewPathTest, TurnsViewsAsTheTableSays) {
  list("name,x,z,yaw,pitch\na,0,0,90,0\nb,0.25,-0.25,-20,30\n");
  const ViewFrame flat{.fov_deg = 60.0, .size = "40x30"};
  run(80.0, flat);
  Renderer renderer(room_, {.k_deg = 80.0});
  ViewFrame turned = flat;
  turned.yaw_deg = -20.0;
  turned.pitch_deg = 30.0;
  const cv::Mat expected = render_framed(&renderer, {0.25, -0.25}, turned).image;
  EXPECT_EQ(cv::norm(read_picture(out() / "b.png"), expected, cv::NORM_INF), 0.0);
  const auto record = nlohmann::json::parse(read_file(out() / "views.json"));
  EXPECT_EQ(record["fov_deg"], 60.0);
  EXPECT_EQ(record["size_px"], "40x30");
  EXPECT_EQ(record["views"][1]["pitch_deg"], 30.0);
  // Panoramas do not go beside flat pictures, nor views turned another way.
  EXPECT_THAT(run_error(), HasSubstr("another fov_deg"));
  list("name,x,z,yaw\na,0,0,91\n");
  EXPECT_THAT(run_error(80.0, flat), HasSubstr("'a' was rendered at another viewpoint"));
}

TEST_F(ViewPathTest, RendersOnlyMissingPictures) {
  run();
  fs::remove(out() / "a.png");
  const auto kept = fs::last_write_time(out() / "b.png");
  list("name,x,z\na,0,0\nb,0.25,-0.25\nc,0.1,0.1\n");
  EXPECT_THAT(run(), HasSubstr("3 views, 2 of them rendered now"));
  EXPECT_EQ(fs::last_write_time(out() / "b.png"), kept);
  EXPECT_TRUE(fs::exists(out() / "a.png"));
  EXPECT_TRUE(fs::exists(out() / "c.png"));
}

TEST_F(ViewPathTest, NeverMixesSettings) {
  run();
  EXPECT_THAT(run_error(76.0), AllOf(HasSubstr("views.json"), HasSubstr("another k_deg")));
  list("name,x,z\na,0.1,0\n");
  EXPECT_THAT(run_error(), HasSubstr("'a' was rendered at another viewpoint"));
  list("name,x,z\na,0,0\n");
  write_synthetic_room({.scene = {.seed = 2}, .width = 32, .distance_every = 2},
                       directory_ / "room.lf");
  room_ = Room::open(directory_ / "room.lf");
  EXPECT_THAT(run_error(), HasSubstr("another room"));
}

TEST_F(ViewPathTest, ForceReplacesViewsOfOtherSettingsButNoOtherFiles) {
  run();
  const std::string before = read_file(out() / "b.png");
  list("name,x,z\nb,0.1,0\n");
  const auto forced = [&] {
    return write_path(room_, {.options = {.k_deg = 76.0}}, {}, {path()}, {}, out(), true);
  };
  EXPECT_THAT(forced(), HasSubstr("1 views, 1 of them rendered now"));
  EXPECT_NE(read_file(out() / "b.png"), before);
  EXPECT_FALSE(fs::exists(out() / "a.png")) << "not in the new table";
  EXPECT_FALSE(fs::exists(out().string() + ".partial"));

  std::ofstream(out() / "holiday.png") << "mine";
  EXPECT_THAT(error_of(forced), HasSubstr("holiday.png"));
  EXPECT_EQ(read_file(out() / "holiday.png"), "mine");
}

TEST_F(ViewPathTest, NoParameterIsMixed) {
  const ViewOptions usual{.k_deg = 80.0};
  write_path(room_, {.options = usual}, {}, {path()}, {}, out());
  for (const ViewParameter& parameter : kViewParameters) {
    const bool choice = parameter.value.kind == ParameterKind::kChoice;
    const double usual_value = parameter.value.get(usual);
    const double least = choice ? 0.0 : parameter.least;
    ViewOptions other = usual;
    parameter.value.set(&other, usual_value == least ? least + 1.0 : least);
    EXPECT_THAT(error_of([&] { write_path(room_, {.options = other}, {}, {path()}, {}, out()); }),
                HasSubstr(std::string("rendered with another ") + parameter.key));
  }
}

TEST_F(ViewPathTest, RejectsForeignFiles) {
  fs::create_directories(out());
  std::ofstream(out() / "b.png") << "mine";
  EXPECT_THAT(run_error(), AllOf(HasSubstr("b.png"), HasSubstr("another --out")));
  EXPECT_EQ(read_file(out() / "b.png"), "mine");
  EXPECT_FALSE(fs::exists(out() / "views.json"));
  fs::remove(out() / "b.png");
  std::ofstream(out() / "views.json") << "{\"views\": 3}";
  EXPECT_THAT(run_error(), HasSubstr("views.json"));
}

TEST_F(ViewPathTest, RefusesAListBeforeAnyWork) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"name,x,z\na,0,0\n../b,0,0\n", "path.csv:3"},
      {"name,x,z\na,0,0\na,0.1,0\n", "appears twice"},
      {"name,x,z\n,0,0\n", "path.csv:2"},
      {"name,x,z\na,zero,0\n", "path.csv:2"},
      {"name,x,z\na,0,0\nfar,9,9\n", "'far'"},
      {"name,x,z\n", "no views"},
      {"name,x\na,0\n", "'z'"}};
  for (const auto& [text, message] : cases) {
    list(text);
    EXPECT_THAT(run_error(), HasSubstr(message)) << text;
    EXPECT_FALSE(fs::exists(out())) << text;
  }
}

}  // namespace
}  // namespace raywalk::render
