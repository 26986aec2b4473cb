// Views are continuous where the viewpoint crosses a line or a cell's border, and a scene that
// looks the same from everywhere is rendered the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr double kAnglesDeg[] = {45.0, 76.0, 90.0};

TEST(RendererContinuity, InfinitelyFarRoomLooksTheSameFromEverywhere) {
  for (const int distance_width : {96, 40}) {
    SyntheticRoomSpec spec = box_room(96);
    spec.scene.infinitely_far = true;
    spec.overhang_m = 0.1;
    spec.distance_width = distance_width;
    const TestRoom room(spec);
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
SyntheticRoomSpec grid_room() {
  SyntheticRoomSpec spec;
  spec.cells_x = 3;
  spec.cells_z = 2;
  spec.side_m = 0.5;
  spec.spacing_m = 0.1;
  spec.overhang_m = 0.2;
  spec.width = 128;
  return spec;
}

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
  SyntheticRoomSpec spec = grid_room();
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
  const TestRoom room(grid_room());
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
  const TestRoom room(grid_room());
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

}  // namespace
}  // namespace raywalk
