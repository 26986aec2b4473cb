// Whole views in float against the same in double, at the limits of their parameters.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "core/base/parallel.h"
#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

// The same view in float and in double.
struct TwoViews {
  cv::Mat in_float;
  cv::Mat in_double;
  double apart() const { return largest_difference(in_float, in_double); }
};

TwoViews both(const TestRoom& room, ViewOptions options, PlanPoint at) {
  TwoViews views;
  views.in_float = room.image(options, at);
  options.arithmetic = Arithmetic::kDouble;
  views.in_double = room.image(options, at);
  return views;
}

// Where maps are as fine as the view, every row's position is computed in float too, and only
// rounding differs: one grey level in any row.
constexpr double kRounding = 1.0;

TEST(RendererPrecision, FloatEqualsDoubleToOneLevelOnLinesCornersAndBorders) {
  SyntheticRoomSpec spec;
  spec.cells_x = 2;
  spec.cells_z = 2;
  spec.overhang_m = 0.25;
  const TestRoom room(spec);
  for (const PlanPoint at : {PlanPoint{0.0, 0.0},
                             {1.0, 1.0},
                             {-1.0, 0.5},
                             {0.3, 0.0},
                             {0.0, -0.7},
                             {0.3, 1e-9},
                             {0.125, 0.0},
                             {0.37, -0.61}}) {
    for (const Generation generation : kCorrected) {
      for (const double k_deg : {45.0, 90.0}) {
        EXPECT_LE(both(room, {.generation = generation, .k_deg = k_deg}, at).apart(), kRounding)
            << generation_name(generation) << " k " << k_deg << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

TEST(RendererPrecision, FloatEqualsDoubleToOneLevelWithStationsMicrometresOrMetresApart) {
  for (const double spacing_m : {1e-6, 1e-3, 10.0}) {
    const double scale = spacing_m / 0.125;
    const TestRoom room(room_of_spacing(spacing_m));
    for (const Generation generation : kCorrected) {
      EXPECT_LE(both(room, {.generation = generation}, {0.1 * scale, -0.2 * scale}).apart(),
                kRounding)
          << spacing_m;
    }
  }
}

TEST(RendererPrecision, FloatEqualsDoubleToOneLevelForExtremeDistances) {
  for (const auto& [name, stored] : extreme_distances()) {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    spec.stored_distance = stored;
    const TestRoom room(spec);
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : {PlanPoint{0.1, 0.2}, {0.5, -0.5}, {-0.5, 0.0}}) {
        EXPECT_LE(both(room, {.generation = generation}, at).apart(), kRounding)
            << name << ' ' << generation_name(generation);
      }
    }
  }
}

// Coarser maps: float computes positions at their rows only and takes every second column of the
// polar caps from its neighbours; double does neither.
class CoarseMaps : public testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    spec.spacing_m = 0.25;
    spec.width = 512;
    spec.distance_width = 128;
    return spec;
  }
  static constexpr PlanPoint kAt{0.1, 0.2};
  TestRoom room_{spec()};
};

TEST_F(CoarseMaps, FloatEqualsDoubleToOneLevelFartherThan45DegreesFromThePoles) {
  for (const Generation generation : kCorrected) {
    const TwoViews views = both(room_, {.generation = generation}, kAt);
    const cv::Range away_from_poles(spec().width / 8, 3 * spec().width / 8);
    EXPECT_LE(largest_difference(views.in_float.rowRange(away_from_poles),
                                 views.in_double.rowRange(away_from_poles)),
              kRounding);
    EXPECT_LE(views.apart(), 20.0);
    EXPECT_LT(mean_difference(views.in_float, views.in_double), 0.2);
  }
}

TEST_F(CoarseMaps, DoubleIsNearerToTheTruth) {
  for (const Generation generation : kCorrected) {
    const TwoViews views = both(room_, {.generation = generation}, kAt);
    const cv::Mat truth = room_.truth(kAt);
    EXPECT_GT(psnr_db(views.in_double, truth), psnr_db(views.in_float, truth) + 1.5)
        << generation_name(generation);
  }
}

TEST_F(CoarseMaps, InitialViewsDifferByOneLevelAtMost) {
  for (const int width : {0, 1024, 96}) {
    EXPECT_LE(both(room_, {.generation = Generation::kInitial, .width = width}, kAt).apart(),
              kRounding)
        << width;
  }
}

TEST(RendererPrecision, PicturesAreTheSameFromRunToRunOnAnyNumberOfThreads) {
  SyntheticRoomSpec spec;
  spec.cells_x = 2;
  spec.overhang_m = 0.25;
  spec.width = 256;
  spec.distance_width = 128;
  const TestRoom room(spec);
  const PlanPoint at{0.4, -0.1};
  for (const Generation generation : kGenerations) {
    for (const Arithmetic arithmetic : {Arithmetic::kFloat, Arithmetic::kDouble}) {
      const ViewOptions options{
          .generation = generation, .k_deg = 76.0, .width = 320, .arithmetic = arithmetic};
      const cv::Mat first = room.image(options, at);
      for (const int threads : {1, 2, 3, 8, 2}) {
        set_thread_count(threads);
        EXPECT_EQ(largest_difference(room.image(options, at), first), 0.0)
            << generation_name(generation) << ' ' << threads << " threads";
      }
      set_thread_count(0);
    }
  }
}

}  // namespace
}  // namespace raywalk
