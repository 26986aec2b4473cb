// Checks the spacing rule (core/geometry/spacing.h) on rendered pictures: stations are moved apart
// until the blended picture has the error of one displaced by the tolerance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/spacing.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk::build_lf {
namespace {

constexpr int kWidth = 1024;
constexpr double kHalfPatchDeg = 3.0;

// A wall in front of a rail along x: the distance within the patch around theta = 0 is `distance_m`
// to 0.2 %.
SyntheticScene wall_at(double distance_m) {
  SyntheticScene scene;
  const double far_m = 20.0 * distance_m;
  scene.walls = {{-far_m, -far_m, -far_m}, {far_m, far_m, distance_m}};
  // About 12 pixels, so that a displacement of half a pixel is measurable.
  scene.texture_wavelength_m = distance_m * angle_of_pixels(12.0, kWidth);
  return scene;
}

// Mean squared difference, over the patch in front, between the view and the mean of two others,
// shifted by `shift_px` columns to either side.
double blend_error(const cv::Mat& view, const cv::Mat& left, const cv::Mat& right,
                   double shift_px) {
  const auto level = [](const cv::Mat& image, double u, int v, int channel) {
    const int whole = static_cast<int>(std::floor(u));
    const double part = u - whole;
    const auto at = [&](int column) {
      return static_cast<double>(image.at<cv::Vec3b>(v, column)[channel]);
    };
    // Catmull-Rom cubic: the blur of linear interpolation would exceed the effect of the
    // displacement.
    const double a = at(whole - 1), b = at(whole), c = at(whole + 1), d = at(whole + 2);
    return b +
           0.5 * part * (c - a + part * (2 * a - 5 * b + 4 * c - d + part * (3 * (b - c) + d - a)));
  };
  const int half = static_cast<int>(kHalfPatchDeg / 360.0 * kWidth);
  double sum = 0.0;
  int count = 0;
  for (int v = kWidth / 4 - half; v < kWidth / 4 + half; ++v) {
    for (int u = kWidth / 2 - half; u < kWidth / 2 + half; ++u) {
      for (int channel = 0; channel < 3; ++channel) {
        const double blend =
            0.5 * (level(left, u - shift_px, v, channel) + level(right, u + shift_px, v, channel));
        const double difference = blend - level(view, u, v, channel);
        sum += difference * difference;
        ++count;
      }
    }
  }
  return sum / count;
}

struct Case {
  double distance_m;
  double tolerance_px;
  double assumed_inverse;  // that the samples are moved by; 0: blended in place
};

class MeasuredSpacing : public testing::TestWithParam<Case> {};

TEST_P(MeasuredSpacing, ErrorReachesTheToleranceAtThePredictedSpacing) {
  const Case& c = GetParam();
  const SyntheticScene scene = wall_at(c.distance_m);
  const cv::Mat view = render_scene(scene, {0, 0, 0}, kWidth);
  const double of_tolerance = blend_error(view, view, view, 0.5 * c.tolerance_px);
  const double inverse = 1.0 / c.distance_m, nearer = std::min(inverse, c.assumed_inverse);
  const double rule_m = spacing_needed({nearer, nearer}, std::abs(inverse - c.assumed_inverse),
                                       angle_of_pixels(c.tolerance_px, kWidth));
  const auto error_at = [&](double step_m) {
    const double half_m = 0.5 * step_m;
    const cv::Mat left = render_scene(scene, {-half_m, 0, 0}, kWidth);
    const cv::Mat right = render_scene(scene, {half_m, 0, 0}, kWidth);
    // The left station sees the point straight ahead further to the right: + columns.
    const double moved_px = -std::atan(half_m * c.assumed_inverse) / angle_of_pixels(1.0, kWidth);
    return blend_error(view, left, right, moved_px);
  };
  // The error grows with the square of the gap: 10 % of the step changes it by 20 %.
  EXPECT_LT(error_at(0.9 * rule_m), of_tolerance);
  EXPECT_GT(error_at(1.1 * rule_m), of_tolerance);
}

INSTANTIATE_TEST_SUITE_P(Scenes, MeasuredSpacing,
                         testing::Values(Case{1.0, 2.0, 0.0}, Case{1.0, 4.0, 0.0},
                                         Case{25.0, 3.0, 0.0}, Case{0.2, 3.0, 0.0},
                                         // Chai's optimal depth for a scene from 1 m to the sky.
                                         Case{1.0, 3.0, 0.5},
                                         // Distances 10 % too large.
                                         Case{2.0, 2.0, 0.45}, Case{2.0, 3.0, 0.55}));

}  // namespace
}  // namespace raywalk::build_lf
