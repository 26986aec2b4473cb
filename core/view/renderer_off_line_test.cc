// Views from stations beside, above and below their lines.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/test_room.h"
#include "core/view/view_plan.h"

namespace raywalk {
namespace {

// Every station off its line by up to a share of the cell, at random: across, and up or down.
std::function<OffLine(const std::string&, int)> scattered(double across, double up) {
  return [=](const std::string& line, int station) {
    std::seed_seq seed{static_cast<int>(line[0]), static_cast<int>(line[1]), station};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const double across_share = share(random);
    return OffLine{across * across_share, up * share(random)};
  };
}

// A room of cell side 1 m whose stations are off their lines.
SyntheticRoomSpec uneven_room(double across_m, double up_m) {
  SyntheticRoomSpec spec = box_room();
  spec.scene.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}};
  spec.off_line = scattered(across_m, up_m);
  return spec;
}

// Enough that the mean does not depend on how single silhouettes meet the pixels.
const std::vector<PlanPoint> kUnevenViewpoints = {{0.0, 0.0},    {0.23, 0.31},  {-0.31, 0.12},
                                                  {-0.2, -0.35}, {0.12, -0.18}, {0.37, -0.07}};

// Against the truth at the height of the views, which is that of the stations around.
double mean_psnr(const TestRoom& room, ViewMethod method) {
  Renderer renderer(room.room(), {.method = method});
  double sum_db = 0.0;
  for (const PlanPoint at : kUnevenViewpoints) {
    SyntheticRoomSpec there = room.spec();
    there.height_m = ViewPlan(room.room().grid(), at, {kHalfPi, 0.0}).height_m();
    sum_db += psnr_db(renderer.render(at).image, render_truth(there, at, there.width));
  }
  return sum_db / static_cast<double>(kUnevenViewpoints.size());
}

TEST(RendererOffLine, ViewsAreAsGoodAsFromStationsOnTheLines) {
  const TestRoom on_line(uneven_room(0.0, 0.0)), beside(uneven_room(0.1, 0.0)),
      above(uneven_room(0.0, 0.1)), far_off(uneven_room(0.2, 0.2));
  for (const ViewMethod method : kCorrected) {
    const double on_line_db = mean_psnr(on_line, method);
    EXPECT_GT(on_line_db, 41.0);
    EXPECT_GT(mean_psnr(beside, method), on_line_db - 0.7);
    EXPECT_GT(mean_psnr(above, method), on_line_db - 0.7);
    EXPECT_GT(mean_psnr(far_off, method), on_line_db - 3.0);
  }
}

}  // namespace
}  // namespace raywalk
