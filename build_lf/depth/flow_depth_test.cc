#include "build_lf/depth/flow_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kFlowSize{256, 128};

// A pixel of parallax over half the cell's side, as an inverse distance.
double pixel_per_m(double reach_m) { return kTwoPi / kFlowSize.width / reach_m; }

SyntheticRoomSpec captured_line(double scale, unsigned seed = 1) {
  SyntheticRoomSpec spec = line_of_scale(scale, seed);
  spec.width = kFlowSize.width;
  return spec;
}

InverseDistanceMap truth_at(const SyntheticRoomSpec& spec, const Grid& grid, StationIndex station) {
  return true_map(spec.scene, grid.station(station).position_m, kFlowSize);
}

class FlowDepthOfScale : public ::testing::TestWithParam<double> {};

TEST_P(FlowDepthOfScale, FindsTheWallsOfABox) {
  const double reach_m = 0.5 * GetParam();
  for (const unsigned seed : {1U, 2U}) {
    const SyntheticRoomSpec spec = captured_line(GetParam(), seed);
    const DepthTestRoom room(spec);
    const StationIndex station{0, 8};
    const auto map =
        flow_map(room.room(), station, reach_m, kFlowSize, unit_gain_fields(room.grid()));
    const auto truth = truth_at(spec, room.grid(), station);
    EXPECT_EQ(map.station, station);
    EXPECT_EQ(map.position_m, truth.position_m);
    const double all = share_within(map, truth, pixel_per_m(reach_m));
    EXPECT_GT(all, 0.75) << seed;
    // Confident pixels are more often right.
    const auto certain = [&](size_t pixel) { return map.confidence[pixel] > 160; };
    EXPECT_GT(share_within(map, truth, pixel_per_m(reach_m), certain), all + 0.03) << seed;
  }
}

TEST_P(FlowDepthOfScale, IsLessCertainAtTheEndOfALine) {
  const SyntheticRoomSpec spec = captured_line(GetParam());
  const double reach_m = 0.5 * GetParam();
  const DepthTestRoom room(spec);
  for (const int end : {0, 16}) {
    const auto map =
        flow_map(room.room(), {0, end}, reach_m, kFlowSize, unit_gain_fields(room.grid()));
    const auto truth = truth_at(spec, room.grid(), {0, end});
    EXPECT_GT(share_within(map, truth, pixel_per_m(reach_m)), 0.7);
    EXPECT_LE(*std::max_element(map.confidence.begin(), map.confidence.end()), 128);
  }
}

INSTANTIATE_TEST_SUITE_P(CellSides, FlowDepthOfScale, ::testing::Values(0.2, 1.0, 5.0));

TEST(FlowDepthTest, FindsInfinityFarAway) {
  SyntheticRoomSpec spec = captured_line(1.0);
  spec.scene.infinitely_far = true;
  const DepthTestRoom room(spec);
  const auto map = flow_map(room.room(), {0, 5}, 0.5, kFlowSize, unit_gain_fields(room.grid()));
  for (const float inverse : map.inverse) ASSERT_LT(inverse, 0.1 * pixel_per_m(0.5));
}

TEST(FlowDepthTest, FillsUnknownPixelsAlongTheRail) {
  const SyntheticRoomSpec spec = captured_line(1.0);
  const DepthTestRoom room(spec);
  const auto map = flow_map(room.room(), {0, 8}, 0.5, kFlowSize, unit_gain_fields(room.grid()));
  // Line x0 runs along x, which is theta = +-90 degrees.
  const auto at = [&](int theta, int phi) {
    return static_cast<size_t>(theta * kFlowSize.height + phi);
  };
  for (const int along : {kFlowSize.width / 4, 3 * kFlowSize.width / 4}) {
    EXPECT_EQ(map.confidence[at(along, kFlowSize.height / 2)], 0);
    int left = along;
    int right = along;
    while (map.confidence[at(left, kFlowSize.height / 2)] == 0) --left;
    while (map.confidence[at(right, kFlowSize.height / 2)] == 0) ++right;
    EXPECT_LT(right - left, kFlowSize.width / 8);
    EXPECT_EQ(map.inverse[at(along, kFlowSize.height / 2)],
              std::min(map.inverse[at(left, kFlowSize.height / 2)],
                       map.inverse[at(right, kFlowSize.height / 2)]));
  }
}

TEST(FlowDepthTest, EqualisesExposuresFirst) {
  const SyntheticRoomSpec spec = captured_line(1.0);
  auto gains = unit_gain_fields(synthetic_grid(spec));
  for (size_t i = 0; i < gains[0].size(); ++i) {
    gains[0][i].whole *= i % 2 == 0 ? 1.25f : 1.0f;
  }
  const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
    const double gain = gain_field(gains, station).whole[0];
    cv::multiply(*frame, cv::Scalar::all(1.0 / gain), *frame);
  });
  const DepthTestRoom constant(spec);
  // Exposures alternate, and a quarter of the reach is three stations away.
  const StationIndex station{0, 8};
  const double reach_m = 4.0 * 3.0 * spec.spacing_m;
  const auto truth = truth_at(spec, room.grid(), station);
  const auto share = [&](const Room& captured, const auto& applied) {
    return share_within(flow_map(captured, station, reach_m, kFlowSize, applied), truth,
                        pixel_per_m(0.5));
  };
  EXPECT_NEAR(share(room.room(), gains), share(constant.room(), unit_gain_fields(room.grid())),
              0.03);
}

TEST(FlowDepthTest, GivesEveryPixelAValueInAPlainRoom) {
  SyntheticRoomSpec spec = captured_line(1.0);
  spec.scene.contrast = 0.0;
  const DepthTestRoom room(spec);
  const auto map = flow_map(room.room(), {0, 3}, 0.5, kFlowSize, unit_gain_fields(room.grid()));
  ASSERT_EQ(map.inverse.size(), size_t{256 * 128});
  for (const float inverse : map.inverse) ASSERT_TRUE(std::isfinite(inverse) && inverse >= 0.0f);
}

}  // namespace
}  // namespace raywalk::build_lf
