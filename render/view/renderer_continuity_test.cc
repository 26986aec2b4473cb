// Nothing jumps where the viewpoint crosses a line or a cell's border, and what looks the same from
// everywhere is rendered the same everywhere.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "render/view/renderer.h"
#include "render/view/test_room.h"

namespace raywalk {
namespace {

constexpr Generation kGenerations[] = {Generation::kInitial, Generation::kHlfVd,
                                       Generation::kTwoSided};
constexpr double kAnglesDeg[] = {45.0, 76.0, 90.0};

TEST(RendererContinuity, InfinitelyFarRoomLooksTheSameFromEverywhere) {
  SyntheticRoomSpec spec;
  spec.scene.infinitely_far = true;
  spec.overhang_m = 0.1;
  const TestRoom room(spec);
  const cv::Mat truth = room.truth({0.0, 0.0});
  for (const Generation generation : kGenerations) {
    for (const double k_deg : kAnglesDeg) {
      for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {0.3, -0.17}, {0.5, 0.2}, {-0.5, -0.5}}) {
        const cv::Mat view = room.image({.generation = generation, .k_deg = k_deg}, at);
        EXPECT_LE(largest_difference(view, truth), 1.0)
            << generation_name(generation) << " k " << k_deg << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

// 3 x 2 cells of 0.6 m.
SyntheticRoomSpec grid_room() {
  SyntheticRoomSpec spec;
  spec.cells_x = 3;
  spec.cells_z = 2;
  spec.side_m = 0.6;
  spec.spacing_m = 0.1;
  spec.overhang_m = 0.2;
  return spec;
}

// Pairs of viewpoints 1 um apart on either side of a border between cells: across a line along z,
// across one along x, and through the crossing of both.
constexpr double kStepM = 0.5e-6;
const std::vector<std::pair<PlanPoint, PlanPoint>> kAcross = {
    {{0.3 - kStepM, 0.1}, {0.3 + kStepM, 0.1}},
    {{0.05, -kStepM}, {0.05, kStepM}},
    {{-0.3 - kStepM, -kStepM}, {-0.3 + kStepM, kStepM}}};

// Mean difference in grey levels between the views on either side of each border, the largest.
double largest_jump(const TestRoom& room, const ViewOptions& options) {
  double jump = 0.0;
  for (const auto& [from, to] : kAcross) {
    jump = std::max(jump, mean_difference(room.image(options, from), room.image(options, to)));
  }
  return jump;
}

TEST(RendererContinuity, InitialViewJumpsAtEveryCellBorder) {
  // d_p goes from 0 to N there: what the corrected generations are measured against.
  const TestRoom room(grid_room());
  for (const double k_deg : kAnglesDeg) {
    const ViewOptions options{.generation = Generation::kInitial, .k_deg = k_deg};
    for (const auto& [from, to] : kAcross) {
      EXPECT_GT(mean_difference(room.image(options, from), room.image(options, to)), 10.0);
    }
  }
}

TEST(RendererContinuity, TwoSidedViewDoesNotJump) {
  const TestRoom room(grid_room());
  for (const double k_deg : kAnglesDeg) {
    EXPECT_LT(largest_jump(room, {.generation = Generation::kTwoSided, .k_deg = k_deg}), 0.05);
  }
}

TEST(RendererContinuity, TwoSidedViewDoesNotJumpWhereThingsAreHidden) {
  SyntheticRoomSpec spec = grid_room();
  spec.scene.obstacle = SceneBox{{1.1, -1.2, 0.9}, {1.5, 0.3, 1.3}};
  const TestRoom room(spec);
  for (const double k_deg : kAnglesDeg) {
    EXPECT_LT(largest_jump(room, {.generation = Generation::kTwoSided, .k_deg = k_deg}), 0.1);
  }
}

TEST(RendererContinuity, HlfVdJumpsByNoMoreThanItsResampling) {
  // Both sides show the same exact geometry, sampled from panoramas 0.6 m apart: less than a grey
  // level, a twentieth of the initial view's jump.
  const TestRoom room(grid_room());
  for (const double k_deg : kAnglesDeg) {
    const ViewOptions initial{.generation = Generation::kInitial, .k_deg = k_deg};
    const ViewOptions corrected{.generation = Generation::kHlfVd, .k_deg = k_deg};
    const double jump = largest_jump(room, corrected);
    EXPECT_LT(jump, 1.0);
    EXPECT_LT(jump, largest_jump(room, initial) / 20.0);
  }
}

TEST(RendererContinuity, NothingJumpsInsideACell) {
  const TestRoom room(grid_room());
  for (const Generation generation : kGenerations) {
    const ViewOptions options{.generation = generation, .k_deg = 76.0};
    EXPECT_LT(mean_difference(room.image(options, {0.1 - kStepM, 0.17}),
                              room.image(options, {0.1 + kStepM, 0.17})),
              0.02)
        << generation_name(generation);
  }
}

}  // namespace
}  // namespace raywalk
