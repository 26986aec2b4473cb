// Whole views at the limits of their parameters: viewpoints on lines, corners and borders, stations
// micrometres and metres apart, distances that are wrong in every way, black and white.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

// 2 x 2 cells of 1 m.
SyntheticRoomSpec four_cells() {
  SyntheticRoomSpec spec;
  spec.cells_x = 2;
  spec.cells_z = 2;
  spec.overhang_m = 0.25;
  return spec;
}

// The least and the largest level of a picture's channels.
cv::Point2d levels_of(const cv::Mat& picture) {
  double least = 0.0;
  double most = 0.0;
  cv::minMaxLoc(picture.reshape(1), &least, &most);
  return {least, most};
}

TEST(RendererExtremes, ViewpointsOnLinesCornersAndBordersRenderLikeTheirNeighbours) {
  const TestRoom room(four_cells());
  constexpr double kNanometre = 1e-9;
  const PlanPoint places[] = {{0.0, 0.0},  {1.0, 1.0},   {-1.0, 1.0}, {1.0, 0.0},
                              {0.0, -1.0}, {0.3, 0.0},   {0.0, -0.7}, {1.0, 0.45},
                              {0.5, 1.0},  {0.0, 0.125}, {-0.5, -1.0}};
  for (const Generation generation : kCorrected) {
    for (const double k_deg : {45.0, 76.0, 90.0}) {
      const ViewOptions options{.generation = generation, .k_deg = k_deg};
      for (const PlanPoint& at : places) {
        // A nanometre towards the middle of the room from its edges, away from it elsewhere.
        const auto beside = [](double at_m) {
          return at_m + (std::fabs(at_m) == 1.0 ? -at_m : 1.0) * kNanometre;
        };
        for (const PlanPoint& exact : {at, PlanPoint{beside(at.x_m), beside(at.z_m)}}) {
          const RenderedView view = room.view(options, exact);
          EXPECT_EQ(view.report.empty_share, 0.0);
          EXPECT_GT(psnr_db(view.image, room.truth(exact)), 35.0)
              << generation_name(generation) << " k " << k_deg << " at " << exact.x_m << ','
              << exact.z_m;
        }
      }
    }
  }
}

// Cells of very different station spacing, in a room scaled in proportion; in a room of fixed size
// a cell of micrometres sees it from one point.
TEST(RendererExtremes, StationsMayBeMicrometresOrTensOfMetresApart) {
  SyntheticRoomSpec tiny;
  tiny.side_m = 8e-6;
  tiny.spacing_m = 1e-6;
  const TestRoom point(tiny);
  for (const Generation generation : kGenerations) {
    EXPECT_GT(point.psnr({.generation = generation}, {1.3e-6, -2.1e-6}), 45.0);
  }
  for (const double spacing_m : {1e-6, 10.0}) {
    const double scale = spacing_m / 0.125;
    const TestRoom room(room_of_spacing(spacing_m));
    for (const Generation generation : kCorrected) {
      EXPECT_GT(room.psnr({.generation = generation}, {0.1 * scale, -0.2 * scale}), 35.0)
          << generation_name(generation) << " stations " << spacing_m << " m apart";
    }
  }
}

// For any distance maps a view consists of captured colours: no level outside their range, no
// missing pixel, the same picture every time.
TEST(RendererExtremes, WrongDistancesNeverGiveInvalidPictures) {
  const cv::Point2d captured{38.0, 218.0};  // range of the walls' levels
  for (const auto& [name, stored] : extreme_distances()) {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    spec.stored_distance = stored;
    const TestRoom room(spec);
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : {PlanPoint{0.1, 0.2}, {0.5, -0.5}, {-0.5, 0.0}}) {
        for (const int layers : {0, 1, 7}) {
          const ViewOptions options{.generation = generation, .layers = layers};
          const RenderedView view = room.view(options, at);
          const cv::Point2d levels = levels_of(view.image);
          EXPECT_GE(levels.x, captured.x - 1.0) << name;
          EXPECT_LE(levels.y, captured.y + 1.0) << name;
          EXPECT_EQ(view.report.empty_share, 0.0) << name;
          EXPECT_LE(view.report.filled_share + view.report.stretched_share, 1.0) << name;
          EXPECT_EQ(largest_difference(view.image, room.image(options, at)), 0.0) << name;
        }
      }
    }
  }
}

// Without parallax there is nothing to correct.
TEST(RendererExtremes, InfinitelyFarOrUnknownEverywhereIsTheInitialView) {
  for (const float stored : {std::numeric_limits<float>::infinity(), 0.0f, 1e8f}) {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    spec.stored_distance = [stored](int, int, double) { return stored; };
    const TestRoom room(spec);
    const PlanPoint at{0.13, -0.21};
    EXPECT_LE(largest_difference(room.image({.generation = Generation::kHlfVd}, at),
                                 room.image({.generation = Generation::kInitial}, at)),
              1.0)
        << stored;
  }
}

TEST(RendererExtremes, BlackStaysBlackAndWhiteStaysWhite) {
  for (const double gain : {0.0, 100.0}) {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    for (const char* line : {"x0", "x1", "z0", "z1"}) spec.line_gain[line] = gain;
    const TestRoom room(spec);
    const double level = gain == 0.0 ? 0.0 : 255.0;
    for (const Generation generation : kGenerations) {
      for (const int width : {0, 64, 200}) {
        const cv::Mat view = room.image({.generation = generation, .width = width}, {0.2, 0.1});
        EXPECT_EQ(levels_of(view), cv::Point2d(level, level)) << generation_name(generation);
      }
    }
  }
}

TEST(RendererExtremes, TheSmallestAndAVeryLargePictureRender) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  const TestRoom room(spec);
  for (const Generation generation : kGenerations) {
    EXPECT_EQ(room.image({.generation = generation, .width = 4}, {0.1, 0.2}).size(),
              cv::Size(4, 2));
  }
  const RenderedView large =
      room.view({.generation = Generation::kInitial, .width = 16384}, {0.1, 0.2});
  EXPECT_EQ(large.image.size(), cv::Size(16384, 8192));
  EXPECT_EQ(large.report.empty_share, 0.0);
}

}  // namespace
}  // namespace raywalk
