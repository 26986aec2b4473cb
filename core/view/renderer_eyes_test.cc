// Views of eyes above and below the lines, and for two eyes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"

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

}  // namespace
}  // namespace raywalk
