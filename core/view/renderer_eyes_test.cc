// Views of eyes above and below the lines, for two eyes, and flat pictures of part of a view.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/panorama/panorama_sampler.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"
#include "core/view/test_viewport.h"

namespace raywalk {
namespace {

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
  SyntheticRoomSpec spec = box_room(kEyesWidth);
  spec.cells_x = 2;
  const TestRoom room(spec);
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
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec = box_room(256);
    spec.spacing_m = 0.25;
    return spec;
  }
  cv::Mat flat(const ViewOptions& options, PlanPoint at, const Viewport& viewport) const {
    return Renderer(room_.room(), options).render(at, viewport).image;
  }
  const std::vector<Viewport> viewports_ = {
      looking(0, 0, 0, 90, 160, 120),      looking(180, 10, 0, 60, 101, 140),
      looking(-70, -35, 25, 100, 160, 90), looking(40, 90, 15, 80, 120, 120),
      looking(-130, -80, -60, 75, 96, 90), looking(10, 0, 90, 20, 64, 48)};

  TestRoom room_{spec()};
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
      EXPECT_GT(psnr_db(picture, true_picture(spec(), at, viewport)), 36.0);
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

// A room whose cameras see nothing of directions with a y below `y`.
SyntheticRoomSpec masked_below(double y) {
  SyntheticRoomSpec spec = box_room(128);
  spec.companion.emplace().hides = [y](const std::string&, int, const Eigen::Vector3d& d) {
    return d.y() < y;
  };
  return spec;
}

// Of a large place that no station shows a flat picture may see a part only; it is filled as in the
// panorama.
TEST(ViewportMasks, WhatNoStationShowsIsFilledAsInThePanorama) {
  const TestRoom room(masked_below(-0.4));
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
