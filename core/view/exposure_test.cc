#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/view/test_gains.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

// Linear between the middles of the patches, around the seam, and constant beyond them at a pole.
double gain_at(const cv::Mat& local, double u, double v, PanoramaSize size) {
  const double x = (u + 0.5) / size.width * local.rows - 0.5;
  const double y = std::clamp((v + 0.5) / size.height * local.cols - 0.5, 0.0, local.cols - 1.0);
  double sum = 0.0;
  for (const int right : {0, 1}) {
    for (const int lower : {0, 1}) {
      const auto column = static_cast<int>(std::floor(x)) + right;
      const auto row = std::min(static_cast<int>(y) + lower, local.cols - 1);
      const double across = x - std::floor(x), down = y - std::floor(y);
      sum += (right == 1 ? across : 1 - across) * (lower == 1 ? down : 1 - down) *
             local.at<cv::Vec3f>((column + 2 * local.rows) % local.rows, row)[0];
    }
  }
  return sum;
}

// All lines with another exposure, and gains that undo it: the room but for rounded positions.
TEST(Exposure, GainsUndoWhatLinesWereExposedBy) {
  SyntheticRoomSpec spec = box_room(96);
  const TestRoom plain(spec);
  spec.line_gain = {{"x0", 0.8}, {"x1", 1.1}, {"z0", 0.7}, {"z1", 0.95}};
  const RoomWithGains room(spec, [](int line, int) {
    const float exposed = std::array{0.8f, 1.1f, 0.7f, 0.95f}[static_cast<std::size_t>(line)];
    return GainField{.whole = ColourGain::all(1.0f / exposed)};
  });
  for (const ViewMethod method : kViewMethods) {
    for (const bool gains : {true, false}) {
      const ViewOptions options{.method = method, .gains = gains};
      const cv::Mat view = Renderer(room.room(), options).render(PlanPoint{0.1, -0.2}).image;
      const cv::Mat expected = plain.image(options, {0.1, -0.2});
      cv::Mat difference;
      cv::absdiff(view, expected, difference);
      const int differ = cv::countNonZero(difference.reshape(1) > 4);
      EXPECT_EQ(differ <= 3, gains) << method_name(method) << ": " << differ;
    }
  }
}

// A grey sky shows the gains themselves, also across the seam of the panoramas.
TEST(Exposure, ViewsOfASkyShowTheGainsOfEveryDirection) {
  SyntheticRoomSpec spec = box_room(96);
  spec.scene.contrast = 0.0;
  spec.scene.infinitely_far = true;
  GainField field;
  field.local.create(48, 24, CV_32FC3);
  for (int theta = 0; theta < 48; ++theta) {
    for (int phi = 0; phi < 24; ++phi) {
      field.local.at<cv::Vec3f>(theta, phi) = cv::Vec3f::all(
          static_cast<float>(0.7 + 0.2 * std::cos((theta + 0.5) / 48 * kTwoPi) + 0.015 * phi));
    }
  }
  const RoomWithGains room(spec, [&](int, int) { return field; });
  for (const ViewMethod method : kViewMethods) {
    const cv::Mat view =
        Renderer(room.room(), {.method = method}).render(PlanPoint{0.3, 0.31}).image;
    for (int u = 0; u < view.cols; ++u) {
      for (int v = 4; v < view.rows - 4; ++v) {  // not beside a pole, where they are constant
        ASSERT_NEAR(view.at<cv::Vec3b>(v, u)[1], 128.0 * gain_at(field.local, u, v, {96, 48}), 1.0)
            << method_name(method) << ' ' << u << ", " << v;
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
