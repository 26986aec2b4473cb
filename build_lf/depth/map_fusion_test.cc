#include "build_lf/depth/map_fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kFusedSize{128, 64};
constexpr double kTolerance_per_m = 0.05;

// True maps at five positions on two intersecting lines.
std::vector<InverseDistanceMap> true_maps(const SyntheticScene& scene) {
  std::vector<InverseDistanceMap> maps;
  for (const Eigen::Vector3d& position_m :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.15, 0, 0), Eigen::Vector3d(-0.15, 0, 0),
        Eigen::Vector3d(0.3, 0, 0.15), Eigen::Vector3d(0.3, 0, -0.15)}) {
    maps.push_back(true_map(scene, position_m, kFusedSize));
    maps.back().station = {0, static_cast<int>(maps.size()) - 1};
  }
  return maps;
}

SyntheticScene room_with_post() {
  SyntheticScene scene;
  scene.obstacle = SceneBox{{-0.1, -1.2, 0.8}, {0.2, 1.0, 1.1}};
  return scene;
}

size_t pixel_at(int theta, int phi) { return static_cast<size_t>(theta * kFusedSize.height + phi); }

TEST(MapFusionTest, KeepsTrueMapsUnchanged) {
  const auto maps = true_maps({});
  for (int which = 0; which < 5; ++which) {
    const auto fused = fuse_maps(maps, which, {kTolerance_per_m});
    const auto& truth = maps[static_cast<size_t>(which)];
    EXPECT_EQ(fused.station, truth.station);
    EXPECT_EQ(fused.position_m, truth.position_m);
    EXPECT_GT(share_within(fused, truth, 0.5 * kTolerance_per_m), 0.98);
    EXPECT_GT(*std::min_element(fused.confidence.begin(), fused.confidence.end()), 0);
  }
}

TEST(MapFusionTest, OutvotesAnErrorOfOneMap) {
  const auto truth = true_maps({});
  for (const float factor : {0.3f, 2.5f}) {
    auto maps = truth;
    const auto wrong = [](size_t pixel) { return pixel / kFusedSize.height % 32 < 12; };
    for (size_t pixel = 0; pixel < maps[0].inverse.size(); ++pixel) {
      if (wrong(pixel)) maps[0].inverse[pixel] *= factor;
    }
    const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
    EXPECT_GT(share_within(fused, truth[0], 0.5 * kTolerance_per_m), 0.97) << factor;
    // Nor does it affect the other maps.
    const auto other = fuse_maps(maps, 1, {kTolerance_per_m});
    EXPECT_GT(share_within(other, truth[1], 0.5 * kTolerance_per_m), 0.97) << factor;
    // The winner had fewer votes there.
    EXPECT_LT(fused.confidence[pixel_at(4, 32)], fused.confidence[pixel_at(24, 32)]);
  }
}

TEST(MapFusionTest, FillsUnknownPixels) {
  const auto truth = true_maps({});
  auto maps = truth;
  const auto unknown = [](size_t pixel) { return pixel / kFusedSize.height % 16 < 8; };
  for (size_t pixel = 0; pixel < maps[2].inverse.size(); ++pixel) {
    if (!unknown(pixel)) continue;
    maps[2].inverse[pixel] = 0.0f;
    maps[2].confidence[pixel] = 0;
  }
  const auto fused = fuse_maps(maps, 2, {kTolerance_per_m});
  EXPECT_GT(share_within(fused, truth[2], 0.5 * kTolerance_per_m, unknown), 0.95);
}

TEST(MapFusionTest, OcclusionIsNoEvidenceAgainstASurface) {
  const SyntheticScene scene = room_with_post();
  const auto maps = true_maps(scene);
  const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
  EXPECT_GT(share_within(fused, maps[0], 0.5 * kTolerance_per_m), 0.96);
  // The wall beside the post is kept, although the post occludes it for other stations.
  const auto wall_behind = [&](size_t pixel) {
    const int theta = static_cast<int>(pixel) / kFusedSize.height;
    return std::abs(theta - kFusedSize.width / 2) < 16 && maps[0].inverse[pixel] < 0.6f;
  };
  EXPECT_GT(share_within(fused, maps[0], 0.5 * kTolerance_per_m, wall_behind), 0.9);
}

TEST(MapFusionTest, KeepsASurfaceThatOnlyOneStationSees) {
  const SyntheticScene scene = room_with_post();
  const std::vector<InverseDistanceMap> maps = {true_map(scene, {0, 0, 0}, kFusedSize),
                                                // From the other side of the post.
                                                true_map(scene, {0.05, 0, 1.9}, kFusedSize)};
  const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
  const auto front = [&](size_t pixel) {
    const auto row = static_cast<int>(pixel) % kFusedSize.height;
    return maps[0].inverse[pixel] > 0.9f && std::abs(row - kFusedSize.height / 2) < 8;
  };
  EXPECT_GT(share_within(fused, maps[0], 0.5 * kTolerance_per_m, front), 0.8);
}

TEST(MapFusionTest, DoesNotDependOnTheOrderOfMaps) {
  auto maps = true_maps(room_with_post());
  const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
  std::reverse(maps.begin(), maps.end());
  const auto reversed = fuse_maps(maps, 4, {kTolerance_per_m});
  EXPECT_GT(share_within(reversed, fused, 0.1 * kTolerance_per_m), 0.98);
}

TEST(MapFusionTest, ScalesWithTheRoom) {
  auto maps = true_maps(room_with_post());
  for (size_t pixel = 0; pixel < maps[0].inverse.size(); pixel += 3) maps[0].inverse[pixel] *= 1.7f;
  const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
  for (InverseDistanceMap& map : maps) {
    map.position_m *= 2.0;
    for (float& inverse : map.inverse) inverse *= 0.5f;
  }
  const auto larger = fuse_maps(maps, 0, {0.5 * kTolerance_per_m});
  for (size_t pixel = 0; pixel < fused.inverse.size(); ++pixel) {
    ASSERT_EQ(larger.inverse[pixel], 0.5f * fused.inverse[pixel]);
  }
  EXPECT_EQ(larger.confidence, fused.confidence);
}

TEST(MapFusionTest, KeepsASingleMap) {
  const std::vector<InverseDistanceMap> maps = {true_maps({})[1]};
  const auto fused = fuse_maps(maps, 0, {kTolerance_per_m});
  EXPECT_GT(share_within(fused, maps[0], 0.1 * kTolerance_per_m), 0.95);
}

// A white post before a grey wall; three of five maps put it onto the wall.
class FusionOfAPlainPost : public ::testing::Test {
 protected:
  FusionOfAPlainPost() {
    with_post_.obstacle = SceneBox{{-0.05, -1.2, 0.9}, {0.05, 1.5, 1.0}};
    truth_ = true_maps(with_post_);
    const auto wall = true_maps({});
    maps_ = truth_;
    for (size_t i = 0; i < maps_.size(); ++i) {
      cv::Mat shown(kFusedSize.width, kFusedSize.height, CV_8UC3, cv::Scalar::all(90));
      for (size_t pixel = 0; pixel < truth_[i].inverse.size(); ++pixel) {
        if (truth_[i].inverse[pixel] == wall[i].inverse[pixel]) continue;
        shown.ptr<cv::Vec3b>()[pixel] = {200, 200, 200};
        if (i == 0) post_.push_back(pixel);
      }
      colours_.push_back(ranges_of({shown, shown, shown}));
      if (i >= 1 && i <= 3) maps_[i].inverse = wall[i].inverse;
    }
  }

  double share_of_post(const InverseDistanceMap& fused) const {
    return share_within(fused, truth_[0], 0.5 * kTolerance_per_m, [&](size_t pixel) {
      return std::binary_search(post_.begin(), post_.end(), pixel);
    });
  }

  SyntheticScene with_post_;
  std::vector<InverseDistanceMap> truth_, maps_;
  std::vector<cv::Mat> colours_;
  std::vector<size_t> post_;  // its pixels, seen from the first station
};

TEST_F(FusionOfAPlainPost, MapsThatShowAnotherColourVoteAgainstASurface) {
  ASSERT_GT(post_.size(), 50U);
  EXPECT_LT(share_of_post(fuse_maps(maps_, 0, {kTolerance_per_m})), 0.3);
  EXPECT_GT(share_of_post(fuse_maps(maps_, 0, {kTolerance_per_m}, colours_)), 0.8);
}

TEST_F(FusionOfAPlainPost, EqualColoursDoNotChangeAnything) {
  for (cv::Mat& ranges : colours_) std::fill_n(ranges.data, 6 * ranges.total(), uchar{90});
  const auto without = fuse_maps(maps_, 0, {kTolerance_per_m});
  const auto with = fuse_maps(maps_, 0, {kTolerance_per_m}, colours_);
  EXPECT_EQ(with.inverse, without.inverse);
  EXPECT_EQ(with.confidence, without.confidence);
}

TEST_F(FusionOfAPlainPost, ColoursOfMaskedPixelsDoNotCount) {
  maps_ = truth_;
  for (const size_t pixel : post_) {
    maps_[0].confidence[pixel] = 0;
    colours_[0].ptr<ColourRange>()[pixel] = {{0, 0, 0}, {0, 0, 0}};
  }
  const auto without = fuse_maps(maps_, 0, {kTolerance_per_m});
  const auto with = fuse_maps(maps_, 0, {kTolerance_per_m}, colours_);
  for (const size_t pixel : post_) ASSERT_EQ(with.confidence[pixel], without.confidence[pixel]);
  EXPECT_GT(share_of_post(with), 0.6);
}

// The lower third of a map: what a dolly hides.
bool is_below(size_t pixel) { return pixel % kFusedSize.height >= kFusedSize.height * 2 / 3; }

void forget_below(InverseDistanceMap* map) {
  for (size_t pixel = 0; pixel < map->inverse.size(); ++pixel) {
    if (!is_below(pixel)) continue;
    map->inverse[pixel] = 0.0f;
    map->confidence[pixel] = 0;
  }
}

TEST(MapFusionTest, UnknownMapsDoNotVoteAgainstASurface) {
  const auto truth = true_maps({});
  auto maps = truth;
  for (size_t i = 0; i < 3; ++i) forget_below(&maps[i]);
  const auto median_below = [&](const FusionOptions& options) {
    const auto fused = fuse_maps(maps, 0, options);
    EXPECT_GT(share_within(fused, truth[0], kTolerance_per_m, is_below), 0.98);
    std::vector<int> confidence;
    for (size_t pixel = 0; pixel < fused.confidence.size(); ++pixel) {
      if (is_below(pixel)) confidence.push_back(fused.confidence[pixel]);
    }
    std::sort(confidence.begin(), confidence.end());
    return confidence[confidence.size() / 2];
  };
  // Two of five have a value, and agree.
  EXPECT_NEAR(median_below({.tolerance_per_m = kTolerance_per_m}), 255 * 2 / 5, 12);
  EXPECT_NEAR(median_below({.tolerance_per_m = kTolerance_per_m, .min_voters = 2}), 255, 30);
  EXPECT_NEAR(median_below({.tolerance_per_m = kTolerance_per_m, .min_voters = 4}), 255 / 2, 15);
}

TEST(MapFusionTest, FallbackMapsVoteOnlyForUnknownPixels) {
  const auto truth = true_maps({});
  auto maps = truth;
  for (size_t i = 0; i < 4; ++i) forget_below(&maps[i]);
  // The last map is right about the floor and wrong elsewhere.
  for (size_t pixel = 0; pixel < maps[4].inverse.size(); ++pixel) {
    if (!is_below(pixel)) maps[4].inverse[pixel] *= 3.0f;
  }
  const FusionOptions options{
      .tolerance_per_m = kTolerance_per_m, .min_voters = 1, .fallback_maps = 1};
  const auto fused = fuse_maps(maps, 0, options);
  EXPECT_GT(share_within(fused, truth[0], kTolerance_per_m, is_below), 0.9);
  const std::span without_last(maps.data(), 4);
  const auto without =
      fuse_maps(without_last, 0, {.tolerance_per_m = kTolerance_per_m, .min_voters = 1});
  for (size_t pixel = 0; pixel < fused.inverse.size(); ++pixel) {
    // The final median reads one row farther.
    if (pixel % kFusedSize.height >= kFusedSize.height * 2 / 3 - 1) continue;
    ASSERT_EQ(fused.inverse[pixel], without.inverse[pixel]);
  }
}

}  // namespace
}  // namespace raywalk::build_lf
