#include "render/view/view_path.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "render/video/test_video.h"
#include "render/view/path_curve.h"
#include "render/view/view_file.h"
#include "render/view/view_video.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(ViewFile, ReadsViewpointsOfEitherSignAndAnyHeight) {
  const Viewpoint viewpoint = viewpoint_from_text("-0.1,2e-1");
  EXPECT_EQ(viewpoint.plan.x_m, -0.1);
  EXPECT_EQ(viewpoint.plan.z_m, 0.2);
  EXPECT_FALSE(viewpoint.height_m);
  const Viewpoint raised = viewpoint_from_text("-0.1, 0.05 2e-1");
  EXPECT_EQ(raised.height_m, 0.05);
  EXPECT_EQ(raised.plan.z_m, 0.2);
  EXPECT_THROW(viewpoint_from_text("1;2"), UsageError);
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
  void expect_b(const cv::Mat& picture) const {
    EXPECT_EQ(cv::norm(read_picture(out() / "b.png"), picture, cv::NORM_INF), 0.0);
  }
  nlohmann::json record() const { return nlohmann::json::parse(read_file(out() / "views.json")); }

  TestDirectory directory_;
  Room room_;
  PictureFormat format_{};
};

TEST_F(ViewPathTest, WritesEveryViewAndItsSettings) {
  EXPECT_THAT(run(), HasSubstr("2 views, 2 of them rendered now"));
  Renderer renderer(room_, {.k_deg = 80.0});
  expect_b(renderer.render({0.25, -0.25}).image);
  const nlohmann::json written = record();
  EXPECT_EQ(written["method"], "hlf-vd");
  EXPECT_EQ(written["k_deg"], 80.0);
  EXPECT_EQ(written["enlargement"], 1.0);
  EXPECT_EQ(written["views"].size(), 2U);
  EXPECT_EQ(written["distances"], "given");
}

// The room's fingerprint tells whether distances have changed, the size how far views are enlarged.
TEST_F(ViewPathTest, ResumesARecordWithoutWhatOtherSettingsTell) {
  run();
  nlohmann::json less = record();
  less.erase("distances");
  less.erase("enlargement");
  write_file_atomically(out() / "views.json", less.dump());
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
  const double enlargement = 72.0 * kTwoPi / room_.panorama().width;
  EXPECT_THAT(run(80.0, {.fov_deg = 90.0, .size = "144x160"}),
              AllOf(HasSubstr("rendered now, enlarged"),
                    HasSubstr(fmt::format("{:.0f} times", enlargement))));
  EXPECT_DOUBLE_EQ(record()["enlargement"], enlargement);
}

TEST_F(ViewPathTest, RendersForTwoEyesAtTheHeightsOfTheTable) {
  list("name,x,y,z,yaw\na,0,0.1,0,90\nb,0.25,-0.2,-0.25,0\n");
  const ViewFrame both{.stereo = Stereo::kOds};
  run(80.0, both);
  Renderer renderer(room_, {.k_deg = 80.0});
  expect_b(renderer.render_stereo({{0.25, -0.25}, -0.2}, 0.063).image);
  const nlohmann::json written = record();
  EXPECT_EQ(written["stereo"], "ods");
  EXPECT_EQ(written["ipd_mm"], 63.0);
  EXPECT_EQ(written["views"][1]["y_m"], -0.2);
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
  expect_b(render_framed(&renderer, {0.25, -0.25}, turned).image);
  const nlohmann::json written = record();
  EXPECT_EQ(written["fov_deg"], 60.0);
  EXPECT_EQ(written["size_px"], "40x30");
  EXPECT_EQ(written["views"][1]["pitch_deg"], 30.0);
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

PathView pose_at(double x_m, double z_m, double yaw_deg = 0.0, double time_s = 0.0) {
  return {.name = "at" + std::to_string(x_m),
          .viewpoint = PlanPoint{x_m, z_m},
          .yaw_deg = yaw_deg,
          .time_s = time_s};
}

double distance(const PathView& a, const PathView& b) {
  return std::hypot(a.viewpoint.plan.x_m - b.viewpoint.plan.x_m,
                    a.viewpoint.plan.z_m - b.viewpoint.plan.z_m);
}

// Paths of 2 to 9 places, some of them twice, in rooms of a tenth of a millimetre to 100 km.
std::vector<PathView> random_path(std::mt19937* random, double scale_m) {
  std::uniform_real_distribution<double> within(-scale_m, scale_m);
  std::vector<PathView> views;
  const int count = 2 + static_cast<int>((*random)() % 8);
  for (int i = 0; i < count; ++i) {
    views.push_back(pose_at(within(*random), within(*random)));
    if ((*random)() % 4 == 0) views.push_back(views.back());
  }
  return views;
}

TEST(PathCurve, GoesThroughEveryPlaceAtAConstantSpeed) {
  std::mt19937 random(7);
  for (const double scale_m : {1e-4, 1.0, 1e5}) {
    for (int round = 0; round < 20; ++round) {
      const std::vector<PathView> views = random_path(&random, scale_m);
      const PathCurve curve(views, Pace::kConstant);
      constexpr int kSteps = 4000;
      int bends = 0;
      std::vector<double> nearest(views.size(), 1e9);
      PathView before = curve.at(0.0);
      const double step_m = curve.length() / kSteps;
      for (int i = 0; i <= kSteps; ++i) {
        const PathView here = curve.at(step_m * i);
        for (std::size_t k = 0; k < views.size(); ++k) {
          nearest[k] = std::min(nearest[k], distance(here, views[k]));
        }
        if (i > 0) {
          EXPECT_LT(distance(before, here), (1.0 + 1e-6) * step_m);
          // In a sharp bend the chord is shorter than the way.
          if (distance(before, here) < 0.99 * step_m) ++bends;
        }
        before = here;
      }
      EXPECT_LT(bends, kSteps / 50);
      for (const double each : nearest) EXPECT_LE(each, 0.6 * step_m);
      EXPECT_EQ(distance(curve.at(0.0), views.front()), 0.0);
      EXPECT_LT(distance(curve.at(curve.length()), views.back()), 1e-12 * scale_m);
    }
  }
}

TEST(PathCurve, EasedMovementsStartAndStopSlowly) {
  const std::vector<PathView> views = {pose_at(0, 0), pose_at(1, 0), pose_at(1, 1)};
  const SmoothMovement movement{.pace = Pace::kEased, .fps = 100.0, .seconds = 2.0};
  const std::vector<PathView> frames = frames_of(views, movement, "walk.csv");
  ASSERT_EQ(frames.size(), 200U);
  EXPECT_EQ(frames[0].name, "walk-00001");
  const double middle = distance(frames[99], frames[100]);
  EXPECT_LT(distance(frames[0], frames[1]), 1e-3 * middle);
  EXPECT_LT(distance(frames[198], frames[199]), 1e-3 * middle);
  EXPECT_LT(distance(frames[199], views[2]), 1e-9);
}

TEST(PathCurve, TurnsTheShortWayAndTakesTimeForIt) {
  const std::vector<PathView> views = {pose_at(0, 0, 170), pose_at(1, 0, -170)};
  const PathCurve curve(views, Pace::kConstant);
  EXPECT_NEAR(curve.at(0.5 * curve.length()).yaw_deg, 180.0, 1e-9);
  EXPECT_NEAR(curve.length(), 1.0, 1e-12);
  // On the spot: 100 degrees are as long as a metre.
  const std::vector<PathView> turn = {pose_at(0, 0, 0), pose_at(0, 0, 80)};
  EXPECT_NEAR(PathCurve(turn, Pace::kConstant).length(), 0.8, 1e-12);
}

TEST(PathCurve, FollowsRecordedTimes) {
  const std::vector<PathView> views = {pose_at(0, 0, 0, 10), pose_at(1, 0, 0, 11),
                                       pose_at(1, 0, 0, 14), pose_at(2, 0, 0, 15)};
  const PathCurve curve(views, Pace::kRecorded);
  EXPECT_NEAR(curve.length(), 5.0, 1e-9);
  for (const PathView& view : views) {
    EXPECT_NEAR(curve.at(view.time_s - 10.0).viewpoint.plan.x_m, view.viewpoint.plan.x_m, 1e-9);
  }
  EXPECT_EQ(frames_of(views, {.pace = Pace::kRecorded, .fps = 10.0}, "walk.csv").size(), 50U);
  const std::vector<PathView> back = {pose_at(0, 0, 0, 1), pose_at(1, 0, 0, 1)};
  EXPECT_THAT(error_of([&] { frames_of(back, {.pace = Pace::kRecorded}, "walk.csv"); }),
              AllOf(HasSubstr("walk.csv: view 'at1"), HasSubstr("growing times")));
}

TEST(PathCurve, MovementsThatMakeNoSenseAreRefused) {
  const std::vector<PathView> still = {pose_at(1, 2), pose_at(1, 2)};
  EXPECT_THAT(error_of([&] { frames_of(still, {}, "walk.csv"); }), HasSubstr("give --seconds"));
  EXPECT_EQ(frames_of(still, {.fps = 10.0, .seconds = 1.0}, "walk.csv").size(), 10U);
  const std::vector<PathView> far = {pose_at(0, 0), pose_at(1e9, 0)};
  EXPECT_THAT(error_of([&] { frames_of(far, {}, "walk.csv"); }), HasSubstr("1e+06 frames"));
  EXPECT_THROW(require_movement({.seconds = 0.0}), UsageError);
  EXPECT_THROW(require_movement({.seconds = std::nan("")}), UsageError);
  EXPECT_THROW(require_movement({.seconds = 1.0, .speed_m_per_s = 1.0}), UsageError);
  EXPECT_THROW(require_movement({.pace = Pace::kRecorded, .speed_m_per_s = 1.0}), UsageError);
}

TEST(PathCurve, HeightsAreFollowedWhereThereAreAny) {
  std::vector<PathView> views{{.name = "a", .viewpoint = {PlanPoint{0, 0}, 1.0}},
                              {.name = "b", .viewpoint = {PlanPoint{0, 0}, 1.5}}};
  const PathCurve up(views, Pace::kConstant);
  EXPECT_NEAR(up.length(), 0.5, 1e-12);
  EXPECT_NEAR(up.at(0.25).viewpoint.height_m.value(), 1.25, 1e-9);
  for (PathView& view : views) view.viewpoint.height_m.reset();
  views.back().viewpoint.plan.x_m = 1.0;
  EXPECT_FALSE(PathCurve(views, Pace::kConstant).at(0.5).viewpoint.height_m.has_value());
}

cv::Mat grey(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

class ViewVideoTest : public ::testing::Test {
 protected:
  ViewVideoTest() {
    write_synthetic_room({.width = 128}, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
    std::ofstream(request_.table) << "name,x,z,yaw\na,0,0,0\nb,0.25,-0.25,40\nc,0.3,0.1,90\n";
  }
  std::string video(const ViewFrame& frame, const VideoSettings& settings = {.fps = 10}) const {
    return write_video(room_, mode_, frame, request_, settings, directory_ / "walk.mp4");
  }
  // The frames of the video beside the stills of the same request.
  void compare_with_stills(const ViewFrame& frame, cv::Size size) const {
    write_path(room_, mode_, frame, request_, {}, directory_ / "stills");
    const std::vector<cv::Mat> frames = video_frames(directory_ / "walk.mp4", size);
    ASSERT_EQ(frames.size(), 8U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::string name = "path-0000" + std::to_string(i + 1) + ".png";
      // Videos have half the resolution of colours; video_writer_test compares those.
      const cv::Mat still = read_picture(directory_ / "stills" / name);
      EXPECT_GT(cv::PSNR(grey(frames[i]), grey(still)), 35.0) << name;
    }
  }

  TestDirectory directory_;
  Room room_;
  ViewMode mode_{.options = {.k_deg = 80.0}, .k_source = "given"};
  PathRequest request_{.table = directory_ / "path.csv",
                       .movement = SmoothMovement{.fps = 10, .seconds = 0.8}};
};

TEST_F(ViewVideoTest, ShowsWhatStillsShowAndSaysWhatItIs) {
  struct Kind {
    ViewFrame frame;
    cv::Size size;
    const char *summary, *projection, *stereo;
  };
  for (const Kind& kind :
       {Kind{{}, {128, 64}, "a panorama", "equirectangular", "2D"},
        Kind{{.stereo = Stereo::kOds},
             {128, 128},
             "a panorama, ods",
             "equirectangular",
             "top and bottom"},
        Kind{{.fov_deg = 80.0, .size = "96x64"}, {96, 64}, "flat", "none", "none"}}) {
    SCOPED_TRACE(kind.summary);
    EXPECT_THAT(video(kind.frame),
                AllOf(HasSubstr(fmt::format("walk.mp4: 8 frames of {}x{}, 0.8 s, H.264, crf 18, {}",
                                            kind.size.width, kind.size.height, kind.summary)),
                      HasSubstr("distances given")));
    const auto stream = video_stream(directory_ / "walk.mp4");
    EXPECT_EQ(side_data(stream, "Spherical Mapping").value("projection", "none"), kind.projection);
    EXPECT_EQ(side_data(stream, "Stereo 3D").value("type", "none"), kind.stereo);
    compare_with_stills(kind.frame, kind.size);
    fs::remove(directory_ / "walk.mp4");
    fs::remove_all(directory_ / "stills");
  }
}

TEST_F(ViewVideoTest, WhatCannotBeAVideoIsRefusedBeforeAnyWork) {
  EXPECT_THAT(error_of([&] { video({.fov_deg = 80.0, .size = "95x64"}); }), HasSubstr("even"));
  // Between places that can be rendered the curve leaves the cell.
  std::ofstream(request_.table) << "name,x,z\na,0.499,-0.4\nb,0.499,0.499\nc,-0.4,0.499\n";
  EXPECT_THAT(error_of([&] { video({}); }),
              AllOf(HasSubstr("path.csv: view 'path-0000"), HasSubstr("between '"),
                    HasSubstr("outside every cell")));
  EXPECT_EQ(directory_.entries(), 2U);
}

}  // namespace
}  // namespace raywalk::render
