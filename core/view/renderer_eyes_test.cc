// Views of eyes anywhere: where they cross lines and borders of cells, above and below the lines,
// two of them, and flat pictures of part of a view.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/panorama/panorama_sampler.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr double kAnglesDeg[] = {45.0, 76.0, 90.0};

TEST(RendererContinuity, InfinitelyFarRoomLooksTheSameFromEverywhere) {
  for (const int distance_width : {96, 40}) {
    const TestRoom room({.scene = {.infinitely_far = true},
                         .overhang_m = 0.1,
                         .width = 96,
                         .distance_width = distance_width});
    const cv::Mat truth = room.truth({0.0, 0.0});
    for (const ViewMethod method : kViewMethods) {
      for (const double k_deg : kAnglesDeg) {
        for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {0.3, -0.17}, {0.5, 0.2}, {-0.5, -0.5}}) {
          const cv::Mat view = room.image({.method = method, .k_deg = k_deg}, at);
          EXPECT_LE(largest_difference(view, truth), 1.0)
              << method_name(method) << " k " << k_deg << " at " << at.x_m << ',' << at.z_m
              << ", maps of " << distance_width;
        }
      }
    }
  }
}

// 3 x 2 cells of 0.5 m.
const SyntheticRoomSpec kGridRoom{
    .cells_x = 3, .cells_z = 2, .side_m = 0.5, .spacing_m = 0.1, .overhang_m = 0.2};

constexpr double kStepM = 0.5e-6;
constexpr double kXLinesM[] = {-0.75, -0.25, 0.25, 0.75};  // of the lines along z
constexpr double kZLinesM[] = {-0.5, 0.0, 0.5};            // of the lines along x

using Across = std::pair<PlanPoint, PlanPoint>;

// Pairs of viewpoints 1 um apart on either side of borders between two cells.
std::vector<Across> across_borders() {
  std::vector<Across> pairs;
  for (const double x : {kXLinesM[1], kXLinesM[2]}) {
    for (const double z : {-0.35, 0.15}) pairs.push_back({{x - kStepM, z}, {x + kStepM, z}});
  }
  for (const double x : {-0.6, -0.1, 0.4}) pairs.push_back({{x, -kStepM}, {x, kStepM}});
  return pairs;
}

// The same from within onto every outer line, and into every corner and line end on them.
std::vector<Across> onto_outer_lines() {
  const auto inwards = [](double at_m, double edge_m) {
    return std::fabs(at_m) == edge_m ? at_m - std::copysign(2.0 * kStepM, at_m) : at_m;
  };
  std::vector<PlanPoint> places = {{-0.75, 0.15}, {0.75, -0.35}, {0.4, 0.5}, {-0.1, -0.5}};
  for (const double x : kXLinesM) {
    for (const double z : kZLinesM) {
      if (std::fabs(x) == kXLinesM[3] || std::fabs(z) == kZLinesM[2]) places.push_back({x, z});
    }
  }
  std::vector<Across> pairs;
  for (const PlanPoint& at : places) {
    pairs.push_back({{inwards(at.x_m, kXLinesM[3]), inwards(at.z_m, kZLinesM[2])}, at});
  }
  return pairs;
}

// And through every intersection, on both diagonals.
std::vector<Across> all_places() {
  std::vector<Across> all = across_borders();
  for (const double x : {kXLinesM[1], kXLinesM[2]}) {
    all.push_back({{x - kStepM, -kStepM}, {x + kStepM, kStepM}});
    all.push_back({{x - kStepM, kStepM}, {x + kStepM, -kStepM}});
  }
  const std::vector<Across> outer = onto_outer_lines();
  all.insert(all.end(), outer.begin(), outer.end());
  return all;
}

// Difference of the two views of a pair in grey levels: mean over the picture, and maximum.
struct Jump {
  double mean = 0.0;
  double most = 0.0;
};

// The largest of all pairs.
Jump largest_jump(const TestRoom& room, const ViewOptions& options,
                  const std::vector<Across>& pairs) {
  Jump jump;
  for (const auto& [from, to] : pairs) {
    const cv::Mat before = room.image(options, from);
    const cv::Mat after = room.image(options, to);
    jump.mean = std::max(jump.mean, mean_difference(before, after));
    jump.most = std::max(jump.most, largest_difference(before, after));
  }
  return jump;
}

TEST(RendererContinuity, TwoSidedViewDoesNotJump) {
  SyntheticRoomSpec spec = kGridRoom;
  const TestRoom plain(spec);
  spec.scene.obstacle = SceneBox{{1.1, -1.2, 0.9}, {1.5, 0.3, 1.3}};
  const TestRoom hiding(spec);
  for (const double k_deg : kAnglesDeg) {
    for (const SecondSide second_side : {SecondSide::kEverywhere, SecondSide::kFaded}) {
      const ViewOptions options{
          .method = ViewMethod::kTwoSided, .k_deg = k_deg, .second_side = second_side};
      const Jump jump = largest_jump(plain, options, all_places());
      EXPECT_LT(jump.mean, 0.02);
      EXPECT_LE(jump.most, 1.0);
      // A pixel at the obstacle's edge may be seen a micrometre farther on.
      EXPECT_LT(largest_jump(hiding, options, all_places()).mean, 0.03);
    }
  }
}

TEST(RendererContinuity, HlfVdJumpsByNoMoreThanItsResampling) {
  // Both sides show the same exact geometry, sampled from panoramas 0.5 m apart: less than a grey
  // level, a twentieth of the initial view's jump, and nowhere more than 30 levels of 180.
  const TestRoom room(kGridRoom);
  for (const double k_deg : kAnglesDeg) {
    const ViewOptions initial{.method = ViewMethod::kInitial, .k_deg = k_deg};
    const ViewOptions corrected{.method = ViewMethod::kHlfVd, .k_deg = k_deg};
    const Jump jump = largest_jump(room, corrected, all_places());
    EXPECT_LT(jump.mean, 1.0);
    EXPECT_LT(jump.most, 30.0);
    EXPECT_LT(jump.mean, largest_jump(room, initial, all_places()).mean / 20.0);
  }
}

TEST(RendererContinuity, NothingJumpsInACellOrOntoTheOuterLines) {
  const TestRoom room(kGridRoom);
  for (const ViewMethod method : kViewMethods) {
    for (const double k_deg : kAnglesDeg) {
      const ViewOptions options{.method = method, .k_deg = k_deg};
      EXPECT_LE(largest_jump(room, options, onto_outer_lines()).most, 1.0)
          << method_name(method) << " k " << k_deg;
    }
    for (const int stations : {1, 2, 8}) {
      const ViewOptions options{.method = method, .k_deg = 76.0, .stations_mixed = stations};
      EXPECT_LT(largest_jump(room, options, {{{0.1 - kStepM, 0.17}, {0.1 + kStepM, 0.17}}}).mean,
                0.02)
          << method_name(method);
    }
  }
}

constexpr int kEyesWidth = 192;
constexpr double kEyesApart_m = 0.063;
const PlanPoint kEyesAt{0.13, -0.21};

cv::Mat truth_at(const TestRoom& room, const Viewpoint& at) {
  const double y_m = at.height_m.value_or(room.spec().height_m);
  return render_scene(room.spec().scene, Eigen::Vector3d(at.plan.x_m, y_m, at.plan.z_m),
                      room.spec().width);
}

// The left eye's above the right eye's.
cv::Mat stereo_truth(const TestRoom& room, PlanPoint at, double eyes_apart_m) {
  const EyeCircle left{{at.x_m, room.spec().height_m, at.z_m}, 0.5 * eyes_apart_m};
  cv::Mat both = render_scene(room.spec().scene, left, room.spec().width);
  both.push_back(render_scene(room.spec().scene, left.opposite(), room.spec().width));
  return both;
}

const TestRoom& plain_room() {
  static const TestRoom room(box_room(kEyesWidth));
  return room;
}

TEST(RendererHeight, ViewsMatchTheTruthAboveAndBelowTheLines) {
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(plain_room().room(), {.method = method});
    for (const double y_m : {0.01, 0.2, 0.8, -0.2, -0.6}) {
      const Viewpoint at(kEyesAt, y_m);
      EXPECT_GT(psnr_db(renderer.render(at).image, truth_at(plain_room(), at)), 42.0)
          << method_name(method) << ' ' << y_m;
    }
  }
}

TEST(RendererHeight, WithAnOccluderASmallOneLosesLittleAndTheLinesOwnNothing) {
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(pillar_room().room(), {.method = method});
    const auto view = [&](double y_m) { return renderer.render({{-0.1, -0.15}, y_m}).image; };
    const auto psnr = [&](double y_m) {
      return psnr_db(view(y_m), truth_at(pillar_room(), {{-0.1, -0.15}, y_m}));
    };
    EXPECT_EQ(largest_difference(view(0.0), renderer.render({-0.1, -0.15}).image), 0.0);
    for (const double y_m : {0.05, -0.05}) {
      EXPECT_GT(psnr(y_m), psnr(0.0) - 1.0) << method_name(method) << ' ' << y_m;
    }
  }
}

TEST(RendererHeight, AnyFiniteOneRendersButNoneInAnInitialView) {
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(plain_room().room(), {.method = method});
    for (const double y_m : {-5.0, 1e-12, 40.0, 1e9}) {
      EXPECT_EQ(renderer.render({kEyesAt, y_m}).image.cols, kEyesWidth) << "also outside the room";
    }
    EXPECT_THROW(renderer.render({kEyesAt, std::nan("")}), UsageError);
  }
  Renderer renderer(plain_room().room(), {.method = ViewMethod::kInitial});
  EXPECT_THROW(renderer.render({kEyesAt, 0.1}), UsageError);
  EXPECT_THROW(renderer.render_stereo({kEyesAt, 0.1}, kEyesApart_m), UsageError);
}

TEST(RendererStereo, BothEyesMatchTheTruthAndAtOnePlaceTheViewFromThere) {
  const cv::Mat truth = stereo_truth(plain_room(), kEyesAt, kEyesApart_m);
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(plain_room().room(), {.method = method});
    const cv::Mat both = renderer.render_stereo(kEyesAt, kEyesApart_m).image;
    ASSERT_EQ(both.size(), cv::Size(kEyesWidth, kEyesWidth));
    const cv::Mat one = renderer.render(kEyesAt).image;
    const cv::Mat together = renderer.render_stereo(kEyesAt, 1e-7).image;
    for (const int row : {0, kEyesWidth / 2}) {
      const cv::Range eye(row, row + kEyesWidth / 2);
      EXPECT_GT(psnr_db(both.rowRange(eye), truth.rowRange(eye)), 44.0)
          << method_name(method) << ' ' << row;
      EXPECT_LT(mean_difference(together.rowRange(eye), one), 0.02);
    }
  }
}

// What an occluder hides from a line is seen by the other eye's columns, half a turn away.
TEST(RendererStereo, LosesNothingBehindAnOccluder) {
  const PlanPoint at{-0.1, -0.15};
  const cv::Mat truth = stereo_truth(pillar_room(), at, kEyesApart_m);
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(pillar_room().room(), {.method = method});
    EXPECT_GT(psnr_db(renderer.render_stereo(at, kEyesApart_m).image, truth),
              psnr_db(renderer.render(at).image, truth_at(pillar_room(), at)) - 1.5)
        << method_name(method);
  }
}

TEST(RendererStereo, TheCircleMayReachOverALineAndMustNotLeaveTheRoom) {
  const TestRoom room({.cells_x = 2, .overhang_m = 0.25, .width = kEyesWidth});
  Renderer renderer(room.room(), {.method = ViewMethod::kTwoSided});
  // The cells meet at x = 0 and end at x = 1.
  for (const PlanPoint at : {PlanPoint{0.01, 0.2}, PlanPoint{-0.0315, 0.0}, PlanPoint{0.0, 0.3}}) {
    EXPECT_GT(psnr_db(renderer.render_stereo(at, kEyesApart_m).image,
                      stereo_truth(room, at, kEyesApart_m)),
              42.0)
        << at.x_m;
  }
  EXPECT_NO_THROW(renderer.render_stereo({0.968, 0.0}, kEyesApart_m));
  EXPECT_THROW(renderer.render_stereo({0.97, 0.0}, kEyesApart_m), Error);
}

// The picture cut from a whole panorama; interpolated by cubics.
cv::Mat cut_from(const cv::Mat& panorama, const Viewport& viewport) {
  const PanoramaSampler sampler(panorama);
  cv::Mat cut(viewport.height, viewport.width, CV_8UC3);
  for (int u = 0; u < cut.cols; ++u) {
    for (int v = 0; v < cut.rows; ++v) {
      cut.at<cv::Vec3b>(v, u) = cv::Vec3b(sampler.at(ray_of(viewport, u, v)));
    }
  }
  return cut;
}

class ViewportRoom : public testing::Test {
 protected:
  cv::Mat flat(const ViewOptions& options, PlanPoint at, const Viewport& viewport) const {
    return Renderer(room_.room(), options).render(at, viewport).image;
  }
  const std::vector<Viewport> viewports_ = {
      looking(0, 0, 0, 90, 160, 120),      looking(180, 10, 0, 60, 101, 140),
      looking(-70, -35, 25, 100, 160, 90), looking(40, 90, 15, 80, 120, 120),
      looking(-130, -80, -60, 75, 96, 90), looking(10, 0, 90, 20, 64, 48)};

  TestRoom room_{{.spacing_m = 0.25, .overhang_m = 0.25, .width = 256}};
};

// And the panorama, up to interpolation.
TEST_F(ViewportRoom, PicturesMatchACameraAndThePanorama) {
  const PlanPoint at{0.12, -0.2};
  for (const ViewMethod method : kViewMethods) {
    const ViewOptions options{.method = method, .k_deg = 76.0};
    const cv::Mat panorama = room_.image(options, at);
    for (const Viewport& viewport : viewports_) {
      const cv::Mat picture = flat(options, at, viewport);
      EXPECT_GT(psnr_db(picture, cut_from(panorama, viewport)), 40.0)
          << method_name(method) << " yaw " << viewport.attitude.yaw_rad;
      if (method == ViewMethod::kInitial) continue;
      EXPECT_GT(psnr_db(picture, true_picture(room_.spec(), at, viewport)), 36.0);
    }
  }
}

TEST_F(ViewportRoom, ACoarsePictureIsAFineOneAveraged) {
  const ViewOptions options{.method = ViewMethod::kHlfVd};
  const Viewport fine = looking(20, 5, 3, 90, 80, 64);
  const Viewport coarse = looking(20, 5, 3, 90, 40, 32);
  cv::Mat averaged;
  cv::resize(flat(options, {0.1, 0.1}, fine), averaged, {40, 32}, 0, 0, cv::INTER_AREA);
  EXPECT_LE(largest_difference(flat(options, {0.1, 0.1}, coarse), averaged), 2.0);
}

TEST_F(ViewportRoom, OneRendererAlternatesPanoramasAndPictures) {
  Renderer renderer(room_.room(), {.method = ViewMethod::kTwoSided});
  const cv::Mat panorama = renderer.render({0.2, 0.1}).image;
  const cv::Mat first = renderer.render({0.2, 0.1}, viewports_[2]).image;
  renderer.render({-0.4, 0.1}, viewports_[3]);
  EXPECT_EQ(largest_difference(renderer.render({0.2, 0.1}, viewports_[2]).image, first), 0.0);
  EXPECT_EQ(largest_difference(renderer.render({0.2, 0.1}).image, panorama), 0.0);
  EXPECT_THROW(renderer.render({0.2, 0.1}, looking(0, 0, 0, 180, 10, 10)), UsageError);
  // A coarse picture is rendered finer first, up to the largest size.
  EXPECT_EQ(renderer.render({0.1, 0.1}, looking(0, 0, 0, 170, 1, 4000)).image.size(),
            cv::Size(1, 4000));
}

// Of a large place that no station shows a flat picture may see a part only; it is filled as in the
// panorama.
TEST(ViewportMasks, WhatNoStationShowsIsFilledAsInThePanorama) {
  const TestRoom room({.overhang_m = 0.25, .companion = masked_below(-0.4)});
  for (const ViewMethod method : kViewMethods) {
    Renderer renderer(room.room(), {.method = method});
    const cv::Mat panorama = renderer.render({0.1, 0.2}).image;
    for (const double pitch_deg : {-90.0, -55.0, -30.0}) {
      const Viewport viewport = looking(30, pitch_deg, 0, 50, 60, 60);
      EXPECT_GT(psnr_db(renderer.render({0.1, 0.2}, viewport).image, cut_from(panorama, viewport)),
                40.0)
          << method_name(method) << pitch_deg;
    }
  }
}

}  // namespace
}  // namespace raywalk
