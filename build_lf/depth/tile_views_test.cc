#include "build_lf/depth/tile_views.h"

#include <gtest/gtest.h>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

class TilesOfSize : public ::testing::TestWithParam<int> {};

// Also for sizes that are not a multiple of the tile's.
TEST_P(TilesOfSize, CoverEveryPixelOnceAndHaveStationsToCompare) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  const PanoramaSize size{GetParam(), GetParam() / 2};
  const DepthTestRoom room(spec);
  const DepthPlan plan = plan_depth(room.room(), {.width = size.width});
  const auto gains = unit_gain_fields(room.grid());
  PictureCache pictures = pictures_of(room.room(), size, gains);
  const SweepReference& reference = plan.maps[1];
  const std::vector<SweepCandidate> candidates = candidates_near(plan, reference);
  const TileViews views(reference, candidates, plan.reach_m, size, &pictures);
  std::vector<int> covered(static_cast<size_t>(size.width * size.height), 0);
  for (int tile = 0; tile < views.tiles(); ++tile) {
    for (int u = 0; u < views.columns(tile); ++u) {
      for (int v = 0; v < views.rows(tile); ++v) {
        const int pixel = (views.first_column(tile) + u) * size.height + views.first_row(tile) + v;
        ++covered[static_cast<size_t>(pixel)];
      }
    }
    size_t compared = 0;
    for (const auto& side : views.of_tile(tile).side) {
      compared += side.size();
      for (const int i : side) {
        ASSERT_NE(views.view(i).picture, nullptr);
        EXPECT_EQ(views.view(i).to_reference_m,
                  reference.position_m - candidates[static_cast<size_t>(i)].position_m);
      }
    }
    EXPECT_GE(compared, 2U) << tile;
  }
  for (const int times : covered) ASSERT_EQ(times, 1);
}

INSTANTIATE_TEST_SUITE_P(Widths, TilesOfSize, ::testing::Values(32, 36, 100, 128));

TEST(ReferenceTileTest, IsTheMeanOfAPixelsSamplesAndMarksInvalidOnes) {
  const DepthTestRoom room(room_of_scale(1.0));
  const PanoramaSize size{100, 50};
  cv::Mat valid(size.height, size.width, CV_8UC1, cv::Scalar(255));
  valid.at<uchar>(40, 21) = 0;
  const DepthPlan plan = plan_depth(room.room(), {.width = size.width});
  const auto gains = unit_gain_fields(room.grid());
  PictureCache pictures = pictures_of(room.room(), size, gains, valid);
  const TileViews views(plan.maps[1], candidates_near(plan, plan.maps[1]), plan.reach_m, size,
                        &pictures);
  for (int tile = 0; tile < views.tiles(); ++tile) {
    const ReferenceTile reference = reference_tile(views, tile);
    ASSERT_EQ(reference.count, views.columns(tile) * views.rows(tile));
    for (int i = 0; i < reference.count; ++i) {
      const auto at = static_cast<size_t>(i);
      const int theta = views.first_column(tile) + i / views.rows(tile);
      const int phi = views.first_row(tile) + i % views.rows(tile);
      const Eigen::Vector3d direction =
          direction_from_angles(angles_from_pixel({double(theta), double(phi)}, size));
      ASSERT_NEAR(reference.x[at], direction.x(), 1e-6);
      ASSERT_NEAR(reference.y[at], direction.y(), 1e-6);
      ASSERT_NEAR(reference.z[at], direction.z(), 1e-6);
      ASSERT_EQ(channel_of(reference.samples[at], 3) == static_cast<int>(kInvalidDetail),
                theta == 21 && phi == 40);
      double green = 0.0;
      for (const int u : {2 * theta, 2 * theta + 1}) {
        for (const int v : {2 * phi, 2 * phi + 1}) {
          green += channel_of(views.reference().samples[static_cast<size_t>(u * 100 + v)], 1);
        }
      }
      ASSERT_NEAR(channel_of(reference.samples[at], 1), green / 4.0, 0.5);
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
