// Whole views at the limits of their parameters: distances that are wrong in every way, or
// unknown.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <string>

#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

// Extreme contents of distance maps, by name.
std::map<std::string, std::function<float(int, int, double)>> extreme_distances() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto always = [](float metres) { return [metres](int, int, double) { return metres; }; };
  const auto checkerboard = [](float a, float b) {
    return [a, b](int u, int v, double) { return (u / 2 + v / 2) % 2 == 0 ? a : b; };
  };
  return {{"1 um", always(1e-6f)},
          {"100000 km", always(1e8f)},
          {"none", always(0.0f)},
          {"infinite", always(kInfinity)},
          {"less than a float can invert", always(1e-42f)},
          {"the largest float", always(std::numeric_limits<float>::max())},
          {"half a metre, where stations are", always(0.5f)},
          {"near beside far", checkerboard(1e-6f, 1e8f)},
          {"known beside unknown", checkerboard(2.0f, 0.0f)},
          {"infinite beside zero", checkerboard(kInfinity, 0.0f)}};
}

// The least and the largest level of a picture's channels.
cv::Point2d levels_of(const cv::Mat& picture) {
  double least = 0.0;
  double most = 0.0;
  cv::minMaxLoc(picture.reshape(1), &least, &most);
  return {least, most};
}

// For any distance maps a view consists of captured colours: no level outside their range, no
// missing pixel, the same picture every time; whatever is mixed and how it is read.
TEST(RendererExtremes, WrongDistancesNeverGiveInvalidPictures) {
  const cv::Point2d captured{38.0, 218.0};  // range of the walls' levels
  for (const auto& [name, stored] : extreme_distances()) {
    SyntheticRoomSpec spec = box_room(64);
    spec.distance_width = 48;
    spec.stored_distance = stored;
    const TestRoom room(spec);
    for (const ViewMethod method : kCorrected) {
      for (const int stations : {1, 3, 16}) {
        for (const int width : {0, 20, 100}) {
          const ViewOptions options{.method = method, .width = width, .stations_mixed = stations};
          for (const PlanPoint at : {PlanPoint{0.1, 0.2}, {0.5, -0.5}, {-0.5, 0.0}}) {
            const RenderedView view = room.view(options, at);
            const cv::Point2d levels = levels_of(view.image);
            EXPECT_GE(levels.x, captured.x - 1.0) << name;
            EXPECT_LE(levels.y, captured.y + 1.0) << name;
            EXPECT_EQ(view.report.empty_share, 0.0) << name;
            EXPECT_LE(view.report.filled_share + view.report.unseen_share, 1.0) << name;
          }
        }
        ViewOptions cubic{
            .method = method, .interpolation = Interpolation::kCubic, .stations_mixed = stations};
        EXPECT_EQ(largest_difference(room.image(cubic, {0.1, 0.2}), room.image(cubic, {0.1, 0.2})),
                  0.0)
            << name;
      }
    }
  }
}

// Without parallax there is nothing to correct, whichever way the maps say so. Where nothing is
// known the two neighbours are mixed, as in an initial view.
TEST(RendererExtremes, UnknownEverywhereIsInfinitelyFar) {
  const auto view_of = [](float stored, ViewMethod method) {
    SyntheticRoomSpec spec = box_room(96);
    spec.stored_distance = [stored](int, int, double) { return stored; };
    return TestRoom(spec).image({.method = method}, {0.13, -0.21});
  };
  for (const ViewMethod method : kCorrected) {
    const cv::Mat infinite = view_of(std::numeric_limits<float>::infinity(), method);
    EXPECT_LE(largest_difference(view_of(1e8f, method), infinite), 1.0);
  }
  EXPECT_LE(
      largest_difference(view_of(0.0f, ViewMethod::kHlfVd), view_of(0.0f, ViewMethod::kInitial)),
      1.0);
}

}  // namespace
}  // namespace raywalk
