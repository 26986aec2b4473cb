#include "build_lf/depth/plane_sweep.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory_resource>
#include <random>
#include <vector>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/file_memory.h"
#include "build_lf/depth/flow_depth.h"
#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/semi_global.h"
#include "build_lf/depth/sphere_walks.h"
#include "core/files/test_support.h"

namespace raywalk::build_lf {
namespace {

TEST(SweepLayersTest, ReachTheNearestSurfaceInStepsOfAPixelAndAHalf) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-3.0, 3.0);
  for (int trial = 0; trial < 2000; ++trial) {
    const double reach_m = std::pow(10.0, exponent(random));
    // Down to a tenth of the reach.
    const double max_per_m = std::pow(10.0, 0.5 * exponent(random) - 0.5) / reach_m;
    const PanoramaSize size{64 << (trial % 5), 32 << (trial % 5)};
    const SweepLayers layers = sweep_layers(max_per_m, reach_m, size);
    EXPECT_GE(layers.last_per_m(), max_per_m * (1.0 - 1e-12));
    EXPECT_LE(layers.step_per_m * reach_m, 1.5 * kTwoPi / size.width * (1.0 + 1e-12));
    EXPECT_EQ(layers.count % 16, 0);
    EXPECT_GE(layers.count, 16);
    // No more layers than needed.
    EXPECT_LE(layers.count, max_per_m * reach_m * size.width / (1.5 * kTwoPi) + 17.0);
  }
}

constexpr PanoramaSize kSweptSize{128, 64};

// Sweeps one station against all others of a room.
class Sweeper {
 public:
  explicit Sweeper(const Room& room, const cv::Mat& valid = {},
                   std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : room_(room),
        memory_(memory),
        gains_(unit_gain_fields(room.grid())),
        pictures_(pictures_of(room, kSweptSize, gains_, valid, memory)) {
    for (const StationIndex station : all_stations(room.grid())) {
      candidates_.push_back({station, room.grid().station(station).position_m});
    }
  }

  SweepReference reference(StationIndex station) const {
    const PlanPoint& rail = room_.grid().line_of(station).direction;
    return {station, room_.grid().station(station).position_m, {rail.x_m, 0.0, rail.z_m}};
  }

  void sweep_into(CostVolume* volume, StationIndex station, double reach_m, double max_per_m) {
    const TileViews views(reference(station), candidates_, reach_m, kSweptSize, &pictures_);
    sweep(views, sweep_layers(max_per_m, reach_m, kSweptSize), volume);
  }

  InverseDistanceMap map(StationIndex station, double reach_m, double max_per_m) {
    CostVolume volume{{}, {}, std::pmr::vector<std::uint8_t>(memory_), {}, {}};
    sweep_into(&volume, station, reach_m, max_per_m);
    SemiGlobalScratch scratch{std::pmr::vector<std::uint16_t>(memory_)};
    return regularise(volume, reference(station), &scratch);
  }

 private:
  const Room& room_;
  std::pmr::memory_resource* memory_;
  GainFields gains_;
  PictureCache pictures_;
  std::vector<SweepCandidate> candidates_;
};

// Two pixels of parallax over the reach.
double tolerance_per_m(double reach_m) { return 2.0 * kTwoPi / kSweptSize.width / reach_m; }

class SweepOfScale : public ::testing::TestWithParam<double> {};

TEST_P(SweepOfScale, FindsTheWallsOfABox) {
  const double scale = GetParam();
  const double reach_m = 0.5 * scale;
  for (const unsigned seed : {1U, 2U}) {
    SyntheticRoomSpec spec = room_of_scale(scale, seed);
    spec.scene.texture_wavelength_m = 0.5 * scale;
    const DepthTestRoom room(spec);
    Sweeper sweeper(room.room());
    for (const StationIndex station : {StationIndex{0, 8}, StationIndex{2, 0}}) {
      const auto map = sweeper.map(station, reach_m, 1.5 / scale);
      const auto truth = true_map(spec.scene, map.position_m, kSweptSize);
      EXPECT_GT(share_within(map, truth, tolerance_per_m(reach_m)), 0.9) << seed;
    }
  }
}

TEST_P(SweepOfScale, FindsObjectsInTheRoom) {
  const double scale = GetParam();
  SyntheticRoomSpec spec = room_of_scale(scale);
  spec.scene.texture_wavelength_m = 0.5 * scale;
  spec.scene.obstacle =
      SceneBox{Eigen::Vector3d(-0.2, -1.2, 0.9) * scale, Eigen::Vector3d(0.3, 0.4, 1.3) * scale};
  const DepthTestRoom room(spec);
  const auto map = Sweeper(room.room()).map({1, 8}, 0.5 * scale, 4.0 / scale);
  const auto truth = true_map(spec.scene, map.position_m, kSweptSize);
  const auto near = [&](size_t pixel) { return truth.inverse[pixel] > 1.5 / scale; };
  EXPECT_GT(share_within(map, truth, tolerance_per_m(0.5 * scale), near), 0.75);
}

INSTANTIATE_TEST_SUITE_P(CellSides, SweepOfScale, ::testing::Values(0.2, 1.0, 5.0));

// Around the outline of a plain box the half of the views that is compared shows it at the distance
// of the wall as well. The others show the wall there.
TEST(PlaneSweepTest, PrefersTheDistanceAtWhichMoreViewsShowAPlainSurface) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.scene.texture_wavelength_m = 0.5;
  SyntheticScene with_box = spec.scene;
  with_box.obstacle = SceneBox{{-0.6, -0.6, 1.3}, {0.6, 0.6, 1.5}};
  const Grid grid = synthetic_grid(spec);
  const auto is_box = [&](const Eigen::Vector3d& from_m, int u, int v) {
    const Eigen::Vector3d direction =
        direction_from_angles(angles_from_pixel({double(u), double(v)}, kSweptSize));
    return distance_at(with_box, from_m, direction) < distance_at(spec.scene, from_m, direction);
  };
  const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
    const auto& from_m = grid.station(station).position_m;
    for (const auto [u, v] : pixels_of({frame->cols, frame->rows})) {
      if (is_box(from_m, u, v)) frame->at<cv::Vec3b>(v, u) = {255, 255, 255};
    }
  });
  constexpr StationIndex kReference{1, 8};
  CostVolume volume;
  Sweeper sweeper(room.room());
  sweeper.sweep_into(&volume, kReference, 0.5, 2.0);
  const Eigen::Vector3d from_m = grid.lines[1].stations[8].position_m;
  const auto cost_at = [&](size_t pixel, double inverse) {
    const SweepLayers& layers = volume.layers;
    return volume.cost[pixel * layers.count + std::lround(inverse / layers.step_per_m)];
  };
  const InverseDistanceMap box = true_map(with_box, from_m, kSweptSize);
  const InverseDistanceMap wall = true_map(spec.scene, from_m, kSweptSize);
  int outline = 0;
  int preferred = 0;
  for (int v = 24; v < 40; ++v) {
    for (int u = 1; u < kSweptSize.width; ++u) {
      // Near the box's left outline, but without the detail of the outline itself.
      constexpr int kInside = 3;
      if (!is_box(from_m, u, v) || is_box(from_m, u - 1, v)) continue;
      const size_t pixel = pixel_index(u + kInside, v, kSweptSize);
      ++outline;
      if (cost_at(pixel, box.inverse[pixel]) < cost_at(pixel, wall.inverse[pixel])) ++preferred;
    }
  }
  ASSERT_GT(outline, 8);
  EXPECT_GT(preferred, 0.9 * outline);
}

TEST(PlaneSweepTest, FindsInfinityFarAway) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.scene.infinitely_far = true;
  const DepthTestRoom room(spec);
  const auto map = Sweeper(room.room()).map({0, 8}, 0.5, 2.0);
  for (const float inverse : map.inverse) ASSERT_LT(inverse, tolerance_per_m(0.5));
}

TEST(PlaneSweepTest, IsUnknownWithoutOtherStations) {
  const DepthTestRoom room(line_of_scale(1.0));
  const auto gains = unit_gain_fields(room.grid());
  PictureCache pictures = pictures_of(room.room(), kSweptSize, gains);
  const SweepReference reference{{0, 8}, {0, 0, 0}, {1, 0, 0}};
  CostVolume volume;
  sweep(TileViews(reference, {}, 0.5, kSweptSize, &pictures), sweep_layers(2.0, 0.5, kSweptSize),
        &volume);
  EXPECT_THAT(volume.valid, ::testing::Each(0));
  SemiGlobalScratch scratch;
  EXPECT_THAT(regularise(volume, reference, &scratch).confidence, ::testing::Each(0));
}

TEST(PlaneSweepTest, LeavesMaskedPixelsUnknown) {
  const DepthTestRoom room(room_of_scale(1.0));
  cv::Mat valid(kSweptSize.height, kSweptSize.width, CV_8UC1, cv::Scalar(255));
  valid.rowRange(50, kSweptSize.height).setTo(0);
  const auto map = Sweeper(room.room(), valid).map({0, 8}, 0.5, 2.0);
  for (const auto [theta, phi] : pixels_of(kSweptSize)) {
    const int confidence = map.confidence[pixel_index(theta, phi, kSweptSize)];
    if (phi != 20 && phi < 50) continue;
    ASSERT_EQ(confidence > 0, phi == 20);
  }
}

// As where memory is too small for a sweep.
TEST(PlaneSweepTest, IsTheSameInFiles) {
  const DepthTestRoom room(room_of_scale(1.0));
  const TestDirectory directory;
  FileMemory files(directory.path());
  const InverseDistanceMap expected = Sweeper(room.room()).map({0, 8}, 0.5, 2.0);
  const InverseDistanceMap map = Sweeper(room.room(), {}, &files).map({0, 8}, 0.5, 2.0);
  EXPECT_GT(*std::ranges::max_element(map.inverse), 0.0F);
  EXPECT_EQ(map.inverse, expected.inverse);
  EXPECT_EQ(map.confidence, expected.confidence);
}

constexpr PanoramaSize kCostSize{64, 32};
constexpr int kLayers = 32;
constexpr double kStep_per_m = 0.1;

size_t cost_pixel_at(int theta, int phi) { return pixel_index(theta, phi, kCostSize); }

// A volume without information, in a single colour.
CostVolume blank_volume() {
  const size_t pixels = static_cast<size_t>(kCostSize.width * kCostSize.height);
  return {kCostSize,
          {kLayers, kStep_per_m},
          std::pmr::vector<std::uint8_t>(pixels * kLayers, 60),
          std::vector<std::uint8_t>(pixels, 100),
          std::vector<std::uint8_t>(pixels, 1)};
}

// Costs that rise from 0 at `layer` to at most 176.
void set_layer(CostVolume* volume, int theta, int phi, double layer) {
  for (int k = 0; k < kLayers; ++k) {
    volume->cost[cost_pixel_at(theta, phi) * kLayers + k] =
        static_cast<std::uint8_t>(std::min(176.0, 8.0 * (k - layer) * (k - layer)));
  }
}

double layer_of(const InverseDistanceMap& map, int theta, int phi) {
  return map.inverse[cost_pixel_at(theta, phi)] / kStep_per_m;
}

InverseDistanceMap regularised(const CostVolume& volume) {
  SemiGlobalScratch scratch;
  return regularise(volume, {}, &scratch);
}

// Two halves of the sphere with different distances and colours.
double step_layer(int theta) { return theta < kCostSize.width / 2 ? 5.3 : 20.7; }

CostVolume step_volume() {
  CostVolume volume = blank_volume();
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    set_layer(&volume, theta, phi, step_layer(theta));
    volume.luminance[cost_pixel_at(theta, phi)] = theta < kCostSize.width / 2 ? 50 : 150;
  }
  return volume;
}

TEST(SemiGlobalTest, KeepsStepsAndInterpolatesBetweenLayers) {
  const auto map = regularised(step_volume());
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    ASSERT_NEAR(layer_of(map, theta, phi), step_layer(theta), 0.2) << theta << ' ' << phi;
    ASSERT_GT(map.confidence[cost_pixel_at(theta, phi)], 200);
  }
}

TEST(SemiGlobalTest, SmoothsOutWeakOutliers) {
  CostVolume volume = step_volume();
  std::mt19937 random(1);
  for (size_t pixel = 0; pixel < volume.valid.size(); ++pixel) {
    if (random() % 5 != 0) continue;
    const size_t layer = random() % kLayers;
    for (size_t k = 0; k < kLayers; ++k) volume.cost[pixel * kLayers + k] = k == layer ? 0 : 30;
  }
  const auto map = regularised(volume);
  int right = 0;
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    right += std::fabs(layer_of(map, theta, phi) - step_layer(theta)) < 1.0 ? 1 : 0;
  }
  EXPECT_GT(right, 0.97 * kCostSize.width * kCostSize.height);
}

TEST(SemiGlobalTest, CarriesDistancesThroughTheSeam) {
  // The blank pixels have the colour of those beyond the seam, not of those beside them.
  CostVolume volume = blank_volume();
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    if (theta >= 4) set_layer(&volume, theta, phi, theta < kCostSize.width / 2 ? 3.0 : 9.0);
    if (theta >= 4 && theta < kCostSize.width / 2)
      volume.luminance[cost_pixel_at(theta, phi)] = 250;
  }
  const auto map = regularised(volume);
  for (int theta = 0; theta < 4; ++theta) {
    for (int phi = 4; phi < kCostSize.height - 4; ++phi) {
      ASSERT_NEAR(layer_of(map, theta, phi), 9.0, 0.5) << theta << ' ' << phi;
    }
  }
}

TEST(SemiGlobalTest, CarriesDistancesOverThePoles) {
  for (const bool zenith : {true, false}) {
    const auto row = [&](int from_pole) {
      return zenith ? from_pole : kCostSize.height - 1 - from_pole;
    };
    // Two opposite columns: one known up to the pole, the other known, and of another colour, from
    // five rows on.
    CostVolume volume = blank_volume();
    const int known = 5;
    const int open = known + kCostSize.width / 2;
    for (int i = 1; i < kCostSize.height / 2; ++i) set_layer(&volume, known, row(i), 9.0);
    for (int i = 5; i < kCostSize.height / 2; ++i) {
      set_layer(&volume, open, row(i), 3.0);
      volume.luminance[cost_pixel_at(open, row(i))] = 250;
    }
    const auto map = regularised(volume);
    for (int i = 0; i < 5; ++i) ASSERT_NEAR(layer_of(map, open, row(i)), 9.0, 0.5) << i;
  }
}

TEST(SemiGlobalTest, IsInvariantToRotation) {
  // The room turned by a third of a circle gives the map turned by as much.
  std::mt19937 random(3);
  std::vector<double> layers;
  for (int i = 0; i < kCostSize.width * kCostSize.height; ++i)
    layers.push_back(10.0 + random() % 8);
  const int turn = 21;
  CostVolume volume = blank_volume();
  CostVolume turned = blank_volume();
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    const double layer = layers[cost_pixel_at(theta / 8 * 8, phi / 8 * 8)];
    set_layer(&volume, theta, phi, layer);
    set_layer(&turned, (theta + turn) % kCostSize.width, phi, layer);
  }
  const auto map = regularised(volume);
  const auto map_turned = regularised(turned);
  for (const auto [theta, phi] : pixels_of(kCostSize)) {
    ASSERT_NEAR(layer_of(map, theta, phi),
                layer_of(map_turned, (theta + turn) % kCostSize.width, phi), 0.1);
  }
}

TEST(SemiGlobalTest, IsUnknownWhereNothingWasCompared) {
  CostVolume volume = step_volume();
  volume.valid[cost_pixel_at(7, 9)] = 0;
  const auto map = regularised(volume);
  EXPECT_EQ(map.confidence[cost_pixel_at(7, 9)], 0);
  EXPECT_GT(map.confidence[cost_pixel_at(8, 9)], 0);
}

TEST(SemiGlobalTest, SharpMinimaAreMoreConfident) {
  CostVolume vague = step_volume();
  for (auto& cost : vague.cost) cost = static_cast<std::uint8_t>(cost / 20);
  const auto sure = regularised(step_volume());
  const auto unsure = regularised(vague);
  EXPECT_GT(sure.confidence[cost_pixel_at(16, 16)], unsure.confidence[cost_pixel_at(16, 16)] + 50);
}

TEST(SphereWalksTest, CrossEveryPixelOncePerDirection) {
  for (const PanoramaSize size : {PanoramaSize{8, 4}, {32, 16}, {36, 18}, {128, 64}}) {
    std::vector<std::atomic<int>> visits(static_cast<std::size_t>(size.width * size.height));
    for_each_walk(size, [&](Walk walk, int run_up, int steps) {
      for (int i = -run_up; i < steps; ++i) {
        const std::size_t pixel = pixel_index(walk.theta, walk.phi, size);
        ASSERT_LT(pixel, visits.size());
        if (i >= 0) ++visits[pixel];
        walk.advance(size);
      }
    });
    for (const auto& count : visits) EXPECT_EQ(count, kPaths) << size.width;
  }
}

// --- Distances by optical flow along a line ------------------------------------------------------

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
  const auto at = [](int theta) { return pixel_index(theta, kFlowSize.height / 2, kFlowSize); };
  for (const int along : {kFlowSize.width / 4, 3 * kFlowSize.width / 4}) {
    EXPECT_EQ(map.confidence[at(along)], 0);
    int left = along, right = along;
    while (map.confidence[at(left)] == 0) --left;
    while (map.confidence[at(right)] == 0) ++right;
    EXPECT_LT(right - left, kFlowSize.width / 8);
    EXPECT_EQ(map.inverse[at(along)], std::min(map.inverse[at(left)], map.inverse[at(right)]));
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
