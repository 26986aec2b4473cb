// Accuracy of views in rooms whose truth is known in closed form.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

const ViewOptions kInitial{.method = ViewMethod::kInitial};

// A pillar beyond the front right corner, which hides different parts of the walls from every
// viewpoint.
SyntheticRoomSpec room_with_pillar() {
  SyntheticRoomSpec spec = box_room();
  spec.scene.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}};
  return spec;
}

// In the middle, anywhere, on a line, on a corner, and 1 nm inside a line.
const std::vector<PlanPoint> kQualityViewpoints = {{0.0, 0.0},  {0.23, 0.31},      {-0.31, 0.12},
                                                   {0.5, 0.1},  {0.3, -0.5},       {-0.5, 0.5},
                                                   {0.5, -0.5}, {-0.5 + 1e-9, 0.2}};

TEST(RendererQuality, CorrectedViewsMatchTheTruthWhereInitialOnesDoNot) {
  SyntheticRoomSpec spec = box_room();
  spec.height_m = 0.6;
  const TestRoom room(spec);
  for (const PlanPoint at : kQualityViewpoints) {
    EXPECT_LT(room.psnr(kInitial, at), 25.0);
    for (const ViewMethod method : kCorrected) {
      for (const double k_deg : {45.0, 76.0, 90.0}) {
        EXPECT_GT(room.psnr({.method = method, .k_deg = k_deg}, at), 45.0)
            << method_name(method) << " at " << at.x_m << ',' << at.z_m << ", k " << k_deg;
      }
    }
  }
}

TEST(RendererQuality, SoDoThoseOnTheBordersOfSeveralCells) {
  SyntheticRoomSpec spec = box_room(96);
  spec.cells_x = spec.cells_z = 2;
  const TestRoom room(spec);
  for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {1.0, 1.0}, {0.0, -0.7}, {0.3, -1e-9}}) {
    for (const ViewMethod method : kCorrected) {
      EXPECT_GT(room.psnr({.method = method, .k_deg = 76.0}, at), 35.0)
          << method_name(method) << " at " << at.x_m << ',' << at.z_m;
    }
  }
}

// A small room of cell side `scale` metres.
SyntheticRoomSpec scaled_room(double scale) {
  SyntheticRoomSpec spec = box_room(96);
  spec.side_m *= scale;
  spec.spacing_m *= scale;
  spec.overhang_m *= scale;
  spec.scene.walls.min_m *= scale;
  spec.scene.walls.max_m *= scale;
  spec.scene.texture_wavelength_m *= scale;
  return spec;
}

TEST(RendererQuality, CellsOfMicrometresAndKilometresRenderAsOneOfAMetreDoes) {
  for (const ViewMethod method : kCorrected) {
    const auto psnr = [&](double scale) {
      return TestRoom(scaled_room(scale)).psnr({.method = method}, {0.1 * scale, -0.2 * scale});
    };
    const double at_one_metre = psnr(1.0);
    EXPECT_GT(at_one_metre, 35.0);
    for (const double scale : {8e-6, 1e-3, 80.0, 1e3}) {
      EXPECT_NEAR(psnr(scale), at_one_metre, 0.1) << scale;
    }
    // In a room of fixed size a cell of micrometres sees it from one point.
    SyntheticRoomSpec tiny = box_room(96);
    tiny.side_m = 8e-6;
    tiny.spacing_m = 1e-6;
    tiny.overhang_m = 0.0;
    EXPECT_GT(TestRoom(tiny).psnr({.method = method}, {1.3e-6, -2.1e-6}), 45.0);
  }
}

TEST(RendererQuality, SparseAndSmallDistanceMapsSuffice) {
  // Whole fractions of the panoramas' size, another one, and larger ones.
  for (const int width : {96, 48, 64, 240}) {
    SyntheticRoomSpec spec = box_room();
    spec.distance_every = 5;
    spec.distance_width = width;
    const TestRoom room(spec);
    for (const ViewMethod method : kCorrected) {
      for (const PlanPoint at : kQualityViewpoints) {
        EXPECT_GT(room.psnr({.method = method}, at), 34.0)
            << width << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

TEST(RendererQuality, LinesWithoutDistancesUseThoseOfOtherLines) {
  const TestDirectory directory;
  const SyntheticRoomSpec spec = box_room();
  write_synthetic_room(spec, directory / "room.lf");
  for (const char* line : {"x1", "z0", "z1"}) remove_distances(directory / "room.lf", line);
  const Room room = Room::open(directory / "room.lf");
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(room, {.method = method});
    const PlanPoint far_from_maps{0.3, 0.45};
    EXPECT_GT(psnr_db(renderer.render(far_from_maps).image,
                      render_truth(spec, far_from_maps, spec.width)),
              38.0);
  }
}

TEST(RendererQuality, OccludedViewsStayCloseToTheTruthAndTwoSidedOnesFillLess) {
  const TestRoom room(room_with_pillar());
  for (const PlanPoint at : kQualityViewpoints) {
    const RenderedView front = room.view({.method = ViewMethod::kHlfVd}, at);
    const RenderedView both = room.view({.method = ViewMethod::kTwoSided}, at);
    EXPECT_LE(both.report.filled_share, front.report.filled_share);
    for (const RenderedView* view : {&front, &both}) {
      EXPECT_GT(psnr_db(view->image, room.truth(at)), 40.0) << at.x_m << ',' << at.z_m;
    }
  }
  const auto filled = [&](ViewMethod method) {
    return room.view({.method = method}, {0.0, 0.0}).report.filled_share;
  };
  EXPECT_LT(filled(ViewMethod::kTwoSided), filled(ViewMethod::kHlfVd));
}

// A pixel of the output lies beside one of the distances, and is read from other stations than it.
TEST(RendererQuality, NothingIsLeftBlackWhereStationsSeeDifferentThings) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.distance_every = 3;
  const TestRoom room(spec);
  for (const ViewMethod method : kCorrected) {
    for (const int stations : {1, 3}) {
      for (const int width : {100, 256}) {
        for (const PlanPoint at : {PlanPoint{0.1, -0.05}, {-0.35, -0.34}, {0.05, -0.39}}) {
          const cv::Mat view =
              room.image({.method = method, .width = width, .stations_mixed = stations}, at);
          cv::Mat black;
          cv::inRange(view, cv::Scalar::all(0), cv::Scalar::all(30), black);
          EXPECT_EQ(cv::countNonZero(black), 0)
              << method_name(method) << ' ' << stations << " of " << width << " px";
        }
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
