// Accuracy of views in rooms whose truth is known in closed form.
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "core/view/column_renderer.h"
#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

const ViewOptions kInitial{.generation = Generation::kInitial};

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
  const TestRoom room(box_room());
  for (const PlanPoint at : kQualityViewpoints) {
    EXPECT_LT(room.psnr(kInitial, at), 25.0);
    for (const Generation generation : kCorrected) {
      for (const double k_deg : {45.0, 76.0, 90.0}) {
        EXPECT_GT(room.psnr({.generation = generation, .k_deg = k_deg}, at), 45.0)
            << generation_name(generation) << " at " << at.x_m << ',' << at.z_m << ", k " << k_deg;
      }
    }
  }
}

TEST(RendererQuality, ViewsAreAtTheHeightOfTheLines) {
  SyntheticRoomSpec spec = box_room();
  spec.height_m = 0.6;
  const TestRoom room(spec);
  for (const Generation generation : kCorrected) {
    EXPECT_GT(room.psnr({.generation = generation}, {0.2, -0.3}), 45.0);
  }
}

TEST(RendererQuality, MoreLayersAreNeverWorseAndAutoHasEnough) {
  const TestRoom room(box_room());
  const PlanPoint at{0.1, -0.2};
  for (const Generation generation : kCorrected) {
    const auto psnr = [&](int layers) {
      return room.psnr({.generation = generation, .layers = layers}, at);
    };
    double previous = room.psnr(kInitial, at);
    for (const int layers : {1, 4, 16, 64}) {
      EXPECT_GT(psnr(layers), previous) << layers;
      previous = psnr(layers);
    }
    EXPECT_NEAR(psnr(0), psnr(4096), 0.3) << generation_name(generation);
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

TEST(RendererQuality, CellOfAMillimetreAndOfAKilometreRenderAsOneOfAMetreDoes) {
  for (const Generation generation : kCorrected) {
    const auto psnr = [&](double scale) {
      return TestRoom(scaled_room(scale))
          .psnr({.generation = generation}, {0.1 * scale, -0.2 * scale});
    };
    const double at_one_metre = psnr(1.0);
    EXPECT_GT(at_one_metre, 35.0);
    EXPECT_NEAR(psnr(1e-3), at_one_metre, 0.1);
    EXPECT_NEAR(psnr(1e3), at_one_metre, 0.1);
  }
}

TEST(RendererQuality, SparseAndSmallDistanceMapsSuffice) {
  // Of the panoramas' size, whole fractions of it (a column's rows are then placed several at a
  // time), and another fraction.
  for (const int width : {192, 96, 48, 64}) {
    SyntheticRoomSpec spec = box_room();
    spec.distance_every = 5;
    spec.distance_width = width;
    const TestRoom room(spec);
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : kQualityViewpoints) {
        EXPECT_GT(room.psnr({.generation = generation}, at), 34.0)
            << width << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

TEST(RendererQuality, LinesWithoutDistancesUseThoseOfOtherLines) {
  const TestDirectory directory;
  const SyntheticRoomSpec spec = box_room();
  write_synthetic_room(spec, directory / "room.lf");
  for (const char* line : {"x1", "z0", "z1"}) {
    std::filesystem::remove(distance_volume_path(directory / "room.lf", line));
  }
  record_distance_volumes(directory / "room.lf");
  const Room room = Room::open(directory / "room.lf");
  for (const Generation generation : kCorrected) {
    Renderer renderer(room, {.generation = generation});
    const PlanPoint far_from_maps{0.3, 0.45};
    EXPECT_GT(psnr_db(renderer.render(far_from_maps).image,
                      render_truth(spec, far_from_maps, spec.width)),
              38.0);
  }
}

TEST(RendererQuality, TwoSidedSeesWhatIsHiddenFromTheFront) {
  const TestRoom room(room_with_pillar());
  const PlanPoint at{0.0, 0.0};
  const RenderedView front = room.view({.generation = Generation::kHlfVd}, at);
  const RenderedView both = room.view({.generation = Generation::kTwoSided}, at);
  EXPECT_GT(front.report.filled_share, 0.0);
  EXPECT_LT(both.report.filled_share, front.report.filled_share);
  EXPECT_GT(psnr_db(both.image, room.truth(at)), psnr_db(front.image, room.truth(at)));
}

TEST(RendererQuality, OccludedViewsStayCloseToTheTruth) {
  const TestRoom room(room_with_pillar());
  for (const Generation generation : kCorrected) {
    for (const PlanPoint at : kQualityViewpoints) {
      EXPECT_GT(room.psnr({.generation = generation}, at), 40.0) << at.x_m << ',' << at.z_m;
    }
  }
}

// The view that `inputs` describe, from the lines in front.
cv::Mat render_from_front(const ViewInputs& inputs) {
  const int rows = inputs.output.height;
  cv::Mat image(rows, inputs.output.width, CV_8UC3);
  ColumnRenderer columns(inputs);
  std::vector<std::uint8_t> rgb(3 * static_cast<size_t>(rows) + 1);
  for (int u = 0; u < image.cols; ++u) {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, inputs.output).theta_rad;
    const ColumnPlan plan = inputs.plan.column(theta_rad);
    columns.render(u, std::span(plan.front).first(static_cast<size_t>(plan.front_count)),
                   rgb.data());
    for (int v = 0; v < rows; ++v) {
      const std::uint8_t* pixel = rgb.data() + 3 * static_cast<size_t>(v);
      image.at<cv::Vec3b>(v, u) = {pixel[2], pixel[1], pixel[0]};
    }
  }
  return image;
}

TEST(RendererQuality, HiddenPixelsAreBetterFilledFromOtherStationsThanStretched) {
  const TestRoom room(room_with_pillar());
  const PlanPoint at{0.0, 0.0};
  Renderer renderer(room.room(), {.generation = Generation::kHlfVd});
  const ViewInputs& filling = renderer.prepare(at).inputs();
  const ViewInputs stretching{.room = filling.room,
                              .plan = filling.plan,
                              .output = filling.output,
                              .rows = filling.rows,
                              .distances = filling.distances,
                              .layers = filling.layers,
                              .fill_maps = {}};
  const cv::Mat filled = render_from_front(filling);
  const cv::Mat stretched = render_from_front(stretching);
  EXPECT_GT(psnr_db(filled, room.truth(at)), psnr_db(stretched, room.truth(at)) + 1.0);
}

}  // namespace
}  // namespace raywalk
