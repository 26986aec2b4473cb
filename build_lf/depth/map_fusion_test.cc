#include "build_lf/depth/map_fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/surface_choice.h"
#include "build_lf/depth/tile_planes.h"

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

TEST(MapFusionTest, KeepsTrueMapsUnchanged) {
  const auto maps = true_maps({});
  for (int which = 0; which < 5; ++which) {
    const auto fused = fuse_maps(maps, which, {kTolerance_per_m});
    const auto& truth = maps[which];
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
    EXPECT_LT(fused.confidence[pixel_index(4, 32, kFusedSize)],
              fused.confidence[pixel_index(24, 32, kFusedSize)]);
  }
}

template <typename Where>
void forget(const Where& where, InverseDistanceMap* map) {
  for (size_t pixel = 0; pixel < map->inverse.size(); ++pixel) {
    if (!where(pixel)) continue;
    map->inverse[pixel] = 0.0f;
    map->confidence[pixel] = 0;
  }
}

TEST(MapFusionTest, FillsUnknownPixels) {
  const auto truth = true_maps({});
  auto maps = truth;
  const auto unknown = [](size_t pixel) { return pixel / kFusedSize.height % 16 < 8; };
  forget(unknown, &maps[2]);
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

TEST(MapFusionTest, UnknownMapsDoNotVoteAgainstASurface) {
  const auto truth = true_maps({});
  auto maps = truth;
  for (size_t i = 0; i < 3; ++i) forget(is_below, &maps[i]);
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
  for (size_t i = 0; i < 4; ++i) forget(is_below, &maps[i]);
  // The last map is right about the floor and wrong elsewhere.
  for (size_t pixel = 0; pixel < maps[4].inverse.size(); ++pixel) {
    if (!is_below(pixel)) maps[4].inverse[pixel] *= 3.0f;
  }
  FusionOptions options{.tolerance_per_m = kTolerance_per_m, .min_voters = 1, .fallback_maps = 1};
  const auto fused = fuse_maps(maps, 0, options);
  EXPECT_GT(share_within(fused, truth[0], kTolerance_per_m, is_below), 0.9);
  options.fallback_maps = 0;
  const auto without = fuse_maps(std::span(maps).first(4), 0, options);
  for (size_t pixel = 0; pixel < fused.inverse.size(); ++pixel) {
    // The final median reads one row farther.
    if (pixel % kFusedSize.height >= kFusedSize.height * 2 / 3 - 1) continue;
    ASSERT_EQ(fused.inverse[pixel], without.inverse[pixel]);
  }
}

// --- Which surface a pixel shows, by the colours of other stations -------------------------------

constexpr PanoramaSize kChosenSize{256, 128};
constexpr double kChosenPixel_per_m = kTwoPi / (0.5 * kChosenSize.width);

// A room with a box in the middle of a wall's view, captured from a line in front of it.
SyntheticRoomSpec room_with_box() {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = kChosenSize.width;
  spec.scene.obstacle = SceneBox{{-0.15, -0.3, 0.5}, {0.15, 0.3, 0.7}};
  return spec;
}

class SurfaceChoiceTest : public testing::Test {
 protected:
  // The photographs, with so much of their contrast, and noise.
  explicit SurfaceChoiceTest(double contrast = 1.0, double noise_levels = 0.0)
      : room_(spec_, [=](StationIndex station, cv::Mat* frame) {
          frame->convertTo(*frame, -1, contrast, 110.0 * (1.0 - contrast));
          if (noise_levels > 0.0) add_noise(station, noise_levels, frame);
        }) {
    for (int i = 0; i < count(); ++i) {
      colours_.push_back(station_colours(room_.room(), {0, i}, kChosenSize, {}));
      truth_.push_back(true_map(spec_.scene, position_m(i), kChosenSize));
      swept_.push_back(fattened(truth_.back()));
      ranges_.push_back(sampled_ranges(colours_.back(), {}));
    }
  }

  int count() const { return static_cast<int>(room_.grid().lines[0].stations.size()); }
  Eigen::Vector3d position_m(int i) const { return room_.grid().lines[0].stations[i].position_m; }

  // What is near, spread by 3 pixels, as by windows.
  static InverseDistanceMap fattened(InverseDistanceMap map) {
    cv::Mat inverse(map.size.width, map.size.height, CV_32F, map.inverse.data());
    cv::Mat spread;
    cv::dilate(inverse, spread, cv::Mat::ones(7, 7, CV_8U));
    spread.copyTo(inverse);
    return map;
  }

  // 255 where the swept map shows the box, CV_8UC1, [theta][phi].
  cv::Mat box_of(int i) const {
    const InverseDistanceMap without =
        true_map(line_of_scale(1.0).scene, position_m(i), kChosenSize);
    cv::Mat box(kChosenSize.width, kChosenSize.height, CV_8UC1, cv::Scalar(0));
    for (size_t pixel = 0; pixel < without.inverse.size(); ++pixel) {
      if (swept_[i].inverse[pixel] > without.inverse[pixel] + 0.1f) {
        box.data[pixel] = 255;
      }
    }
    return box;
  }

  std::vector<ChoiceView> views_except(int own) const {
    std::vector<ChoiceView> views;
    for (int i = 0; i < count(); ++i) {
      if (i == own) continue;
      views.push_back({{ranges_[i].ptr<ColourRange>(), ranges_[i].total()}, &swept_[i]});
    }
    return views;
  }

  InverseDistanceMap chosen(int own) const {
    return choose_surfaces(swept_[own], colours_[own], views_except(own), kChosenPixel_per_m);
  }

  // The share of what windows made wrong, or of the rest, that is right.
  double right(const InverseDistanceMap& map, int own, bool made_wrong) const {
    const InverseDistanceMap& truth = truth_[own];
    const InverseDistanceMap& swept = swept_[own];
    return share_within(map, truth, 1.5 * kChosenPixel_per_m, [&](size_t pixel) {
      const bool wrong = swept.inverse[pixel] - truth.inverse[pixel] > 1.5 * kChosenPixel_per_m;
      return wrong == made_wrong;
    });
  }

  SyntheticRoomSpec spec_ = room_with_box();
  DepthTestRoom room_;
  std::vector<StationColours> colours_;
  std::vector<InverseDistanceMap> truth_, swept_;
  std::vector<cv::Mat> ranges_;
};

TEST_F(SurfaceChoiceTest, ASurfaceEndsWhereItsColoursDo) {
  const int middle = count() / 2;
  const InverseDistanceMap map = chosen(middle);
  EXPECT_GT(right(map, middle, true), 0.8);
  EXPECT_GT(right(map, middle, false), 0.99);
  EXPECT_EQ(map.confidence, swept_[middle].confidence);
}

class SurfaceChoiceInNoiseTest : public SurfaceChoiceTest {
 protected:
  SurfaceChoiceInNoiseTest() : SurfaceChoiceTest(1.0, 20.0) {}
};

// All that is seen differs by more than what counts as hidden in clean pictures.
TEST_F(SurfaceChoiceInNoiseTest, NoiseDoesNotMakeHiddenSurfacesLikely) {
  EXPECT_GT(right(chosen(count() / 2), count() / 2, false), 0.97);
}

// Where colours differ little, what is hidden weighs more.
class SurfaceChoiceInDuskTest : public SurfaceChoiceTest {
 protected:
  SurfaceChoiceInDuskTest() : SurfaceChoiceTest(0.12) {}
};

TEST_F(SurfaceChoiceInDuskTest, ASurfaceEndsWhereItsColoursDo) {
  EXPECT_GT(right(chosen(count() / 2), count() / 2, true), 0.9);
}

// Two of three views mask the box, and a little around it: they do not speak against it.
TEST_F(SurfaceChoiceInDuskTest, MaskedPixelsSayNothing) {
  for (int i = 0; i < count(); ++i) {
    if (i % 3 == 0) continue;
    cv::Mat valid = 255 - box_of(i);
    ranges_[i] = sampled_ranges(colours_[i], valid);
  }
  const InverseDistanceMap map = chosen(count() / 2);
  EXPECT_GT(right(map, count() / 2, true), 0.8);
  EXPECT_GT(right(map, count() / 2, false), 0.99);
}

// As on gloss, every view shows the box in other colours: nearly all say that what would be behind
// it is hidden.
TEST_F(SurfaceChoiceTest, GlossIsNoHole) {
  for (int i = 0; i < count(); ++i) {
    StationColours shiny = colours_[i];
    shiny.least = shiny.least.clone();
    cv::add(shiny.least, cv::Scalar::all(i % 2 == 0 ? 7 : -7), shiny.least, box_of(i));
    shiny.most = shiny.least;
    ranges_[i] = sampled_ranges(shiny, {});
  }
  const InverseDistanceMap map = chosen(count() / 2);
  EXPECT_GT(right(map, count() / 2, true), 0.9);
  EXPECT_GT(right(map, count() / 2, false), 0.993);
}

TEST_F(SurfaceChoiceTest, UnknownPixelsAndLonelyMapsStayAsTheyAre) {
  const int middle = count() / 2;
  InverseDistanceMap& swept = swept_[middle];
  EXPECT_EQ(choose_surfaces(swept, colours_[middle], std::vector{views_except(middle)[0]},
                            kChosenPixel_per_m)
                .inverse,
            swept.inverse);
  for (size_t pixel = 0; pixel < swept.inverse.size(); pixel += 3) {
    swept.confidence[pixel] = 0;
    swept.inverse[pixel] = 7.0f;
  }
  const InverseDistanceMap map = chosen(middle);
  for (size_t pixel = 0; pixel < swept.inverse.size(); pixel += 3)
    EXPECT_EQ(map.inverse[pixel], 7.0f);
}

Eigen::Vector3d direction_of(int theta, int phi, PanoramaSize size) {
  return direction_from_angles(angles_from_pixel({double(theta), double(phi)}, size));
}

// A floor 1.5 m below, everything else infinitely far; as a plane it goes on above the horizon.
double floor_inverse(const Eigen::Vector3d& direction) { return -direction.y() / 1.5; }

// How far the nearest of a tile's planes is from the floor, at most, over the tile.
double largest_error(const TilePlanes& planes, int column, int row, PanoramaSize size) {
  double least = 1e9;
  for (const Plane& plane : planes.around(column, row, 9)) {
    double largest = 0.0;
    for (int i = 0; i < kPlaneTile * kPlaneTile; ++i) {
      const Eigen::Vector3d direction = direction_of(column * kPlaneTile + i / kPlaneTile,
                                                     row * kPlaneTile + i % kPlaneTile, size);
      const double inverse = plane.cast<double>().dot(direction);
      largest = std::max(largest, std::fabs(inverse - floor_inverse(direction)));
    }
    least = std::min(least, largest);
  }
  return least;
}

// Poles, the seam, and heights that are no multiple of a tile.
TEST(TilePlanesTest, CoverTheWholeSphereAtAnySize) {
  for (const PanoramaSize size : {PanoramaSize{32, 16}, {36, 18}, {256, 128}, {1024, 512}}) {
    InverseDistanceMap map{{}, {0, 0, 0}, size, {}, {}};
    for (const auto [theta, phi] : pixels_of(size)) {
      const double inverse = floor_inverse(direction_of(theta, phi, size));
      map.inverse.push_back(static_cast<float>(std::max(0.0, inverse)));
    }
    map.confidence.assign(map.inverse.size(), 255);
    const TilePlanes planes(map, 8.0 / size.width);
    EXPECT_EQ(planes.columns() * kPlaneTile, size.width);
    EXPECT_GE(planes.rows() * kPlaneTile, size.height);
    const int lowest = size.height / kPlaneTile - 1;
    for (const int column : {0, planes.columns() / 2, planes.columns() - 1}) {
      for (const int row : {lowest, lowest - 1}) {
        EXPECT_LT(largest_error(planes, column, row, size), 4.0 / size.width)
            << size.width << ' ' << column << ' ' << row;
      }
      for (int row = 0; row < planes.rows(); ++row) {
        for (const Plane& plane : planes.around(column, row, 9)) EXPECT_TRUE(plane.allFinite());
      }
    }
    map.confidence.assign(map.inverse.size(), 0);
    EXPECT_TRUE(TilePlanes(map, 8.0 / size.width).around(0, lowest, 9).empty()) << "not known";
  }
}

}  // namespace
}  // namespace raywalk::build_lf
