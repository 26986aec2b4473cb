// Views of eyes above and below the lines, and for two eyes.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_points.h"
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

TEST(RendererHeight, TheLinesOwnHeightChangesNothing) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.height_m = 0.2;
  const TestRoom room(spec);
  for (const Generation generation : kCorrected) {
    Renderer renderer(room.room(), {.generation = generation});
    const cv::Mat without = renderer.render(kEyesAt).image;
    EXPECT_EQ(largest_difference(renderer.render({kEyesAt, 0.2}).image, without), 0.0);
  }
}

TEST(RendererHeight, ViewsMatchTheTruthAboveAndBelowTheLines) {
  for (const Generation generation : kCorrected) {
    Renderer renderer(plain_room().room(), {.generation = generation});
    for (const double y_m : {0.01, 0.2, 0.8, -0.2, -0.6}) {
      const Viewpoint at(kEyesAt, y_m);
      EXPECT_GT(psnr_db(renderer.render(at).image, truth_at(plain_room(), at)), 42.0)
          << generation_name(generation) << ' ' << y_m;
    }
  }
}

TEST(RendererHeight, WithAnOccluderASmallHeightLosesLittle) {
  for (const Generation generation : kCorrected) {
    Renderer renderer(pillar_room().room(), {.generation = generation});
    const auto psnr = [&](double y_m) {
      const Viewpoint at({-0.1, -0.15}, y_m);
      return psnr_db(renderer.render(at).image, truth_at(pillar_room(), at));
    };
    const double level = psnr(0.0);
    for (const double y_m : {0.05, -0.05}) {
      EXPECT_GT(psnr(y_m), level - 1.0) << generation_name(generation) << ' ' << y_m;
    }
  }
}

TEST(RendererHeight, DepthLayersAreThoseOfTheLine) {
  const Viewpoint at(kEyesAt, 0.25);
  for (const Generation generation : kCorrected) {
    Renderer renderer(plain_room().room(), {.generation = generation, .layers = 64});
    EXPECT_GT(psnr_db(renderer.render(at).image, truth_at(plain_room(), at)), 38.0);
  }
}

TEST(RendererHeight, InitialViewsHaveNone) {
  Renderer renderer(plain_room().room(), {.generation = Generation::kInitial});
  EXPECT_THROW(renderer.render({kEyesAt, 0.1}), UsageError);
  EXPECT_THROW(renderer.render_stereo({kEyesAt, 0.1}, kEyesApart_m), UsageError);
}

TEST(RendererHeight, OutsideTheRoomRendersSomething) {
  for (const Generation generation : kCorrected) {
    Renderer renderer(plain_room().room(), {.generation = generation});
    for (const double y_m : {-5.0, 1e-12, 40.0, 1e9}) {
      EXPECT_EQ(renderer.render({kEyesAt, y_m}).image.cols, kEyesWidth);
    }
    EXPECT_THROW(renderer.render({kEyesAt, std::nan("")}), UsageError);
  }
}

TEST(RendererStereo, BothEyesMatchTheTruth) {
  const cv::Mat truth = stereo_truth(plain_room(), kEyesAt, kEyesApart_m);
  for (const Generation generation : kCorrected) {
    Renderer renderer(plain_room().room(), {.generation = generation});
    const cv::Mat both = renderer.render_stereo(kEyesAt, kEyesApart_m).image;
    ASSERT_EQ(both.size(), cv::Size(kEyesWidth, kEyesWidth));
    for (const int row : {0, kEyesWidth / 2}) {
      const cv::Range eye(row, row + kEyesWidth / 2);
      EXPECT_GT(psnr_db(both.rowRange(eye), truth.rowRange(eye)), 44.0)
          << generation_name(generation) << ' ' << row;
    }
  }
}

TEST(RendererStereo, EyesAtOnePlaceSeeTheViewFromThere) {
  for (const Generation generation :
       {Generation::kInitial, Generation::kHlfVd, Generation::kTwoSided}) {
    Renderer renderer(pillar_room().room(), {.generation = generation});
    const cv::Mat one = renderer.render(kEyesAt).image;
    const cv::Mat both = renderer.render_stereo(kEyesAt, 1e-7).image;
    EXPECT_LT(mean_difference(both.rowRange(0, one.rows), one), 0.02);
    EXPECT_LT(mean_difference(both.rowRange(one.rows, both.rows), one), 0.02);
  }
}

// What an occluder hides from a line is seen by the other eye's columns, half a turn away.
TEST(RendererStereo, LosesNothingBehindAnOccluder) {
  const PlanPoint at{-0.1, -0.15};
  const cv::Mat truth = stereo_truth(pillar_room(), at, kEyesApart_m);
  for (const Generation generation : kCorrected) {
    Renderer renderer(pillar_room().room(), {.generation = generation});
    const double one_db = psnr_db(renderer.render(at).image, truth_at(pillar_room(), at));
    const cv::Mat both = renderer.render_stereo(at, kEyesApart_m).image;
    EXPECT_GT(psnr_db(both, truth), one_db - 1.0) << generation_name(generation);
  }
}

// Mean column of a picture's pixels that differ from another one's, by how much they differ.
double centre_of_difference(const cv::Mat& a, const cv::Mat& b) {
  double sum = 0.0;
  double weighted = 0.0;
  for (int v = 0; v < a.rows; ++v) {
    for (int u = 0; u < a.cols; ++u) {
      const double difference =
          cv::norm(cv::Vec3d(a.at<cv::Vec3b>(v, u)) - cv::Vec3d(b.at<cv::Vec3b>(v, u)));
      if (difference < 16.0) continue;
      sum += difference;
      weighted += difference * u;
    }
  }
  return weighted / sum;
}

TEST(RendererStereo, APostIsSeenApartByTwiceItsArcSine) {
  // Around the viewpoint, at a known distance in front of it.
  constexpr double kRho_m = 1.2;
  constexpr double kApart_m = 0.2;
  SyntheticRoomSpec spec = box_room(512);
  const TestRoom empty(spec);
  spec.scene.obstacle = SceneBox{{-0.03, -0.3, kRho_m - 0.03}, {0.03, 0.3, kRho_m + 0.03}};
  const TestRoom with_post(spec);
  const ViewOptions options{.generation = Generation::kTwoSided};
  const auto both_eyes = [&](const TestRoom& room) {
    return Renderer(room.room(), options).render_stereo(PlanPoint{0.0, 0.0}, kApart_m).image;
  };
  const cv::Mat with = both_eyes(with_post);
  const cv::Mat without = both_eyes(empty);
  const auto column = [&](int first_row) {
    const cv::Range eye(first_row, first_row + 256);
    return centre_of_difference(with.rowRange(eye), without.rowRange(eye));
  };
  const double apart_px = 2.0 * std::asin(0.5 * kApart_m / kRho_m) * 512 / kTwoPi;
  EXPECT_NEAR(column(0) - column(256), apart_px, 0.5);
  EXPECT_NEAR(0.5 * (column(0) + column(256)), 255.5, 0.5);
}

TEST(RendererStereo, TheCircleMayReachOverALineAndMustNotLeaveTheRoom) {
  SyntheticRoomSpec spec = box_room(kEyesWidth);
  spec.cells_x = 2;
  const TestRoom room(spec);
  Renderer renderer(room.room(), {.generation = Generation::kTwoSided});
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

TEST(RendererStereo, BesideASingleLineOnlyWhatItServesIsShown) {
  SyntheticRoomSpec spec = box_room(kEyesWidth);
  spec.cells_z = 0;
  const TestRoom room(spec);
  for (const Generation generation : kCorrected) {
    Renderer renderer(room.room(), {.generation = generation});
    const RenderedView view = renderer.render_stereo({0.1, 0.02}, kEyesApart_m);
    EXPECT_EQ(view.image.rows, kEyesWidth);
  }
}

}  // namespace
}  // namespace raywalk
