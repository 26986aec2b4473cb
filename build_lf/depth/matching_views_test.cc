#include "build_lf/depth/matching_views.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/station_picture.h"
#include "build_lf/depth/tile_views.h"
#include "core/panorama/transposed_border.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

using ::testing::IsEmpty;

std::vector<Eigen::Vector3d> positions_of(const Grid& grid) {
  std::vector<Eigen::Vector3d> positions_m;
  for (const StationIndex station : all_stations(grid)) {
    positions_m.push_back(grid.station(station).position_m);
  }
  return positions_m;
}

// Length of the component of the vector to a station that causes parallax.
double baseline_m(const MatchingGeometry& geometry, const Eigen::Vector3d& direction,
                  const Eigen::Vector3d& station_m) {
  const Eigen::Vector3d offset = station_m - geometry.reference_m;
  return (offset - offset.dot(direction) * direction).norm();
}

const std::vector<Eigen::Vector3d>& directions_around() {
  static const std::vector<Eigen::Vector3d> directions = [] {
    std::vector<Eigen::Vector3d> all;
    for (int theta_deg = -180; theta_deg < 180; theta_deg += 10) {
      for (int phi_deg = -75; phi_deg <= 75; phi_deg += 15) {
        all.push_back(direction_from_angles(
            {radians_from_degrees(theta_deg), radians_from_degrees(phi_deg)}));
      }
    }
    return all;
  }();
  return directions;
}

class MatchingViewsOfScale : public ::testing::TestWithParam<double> {
 protected:
  const double side_m_ = GetParam();
  const Grid grid_ = synthetic_grid(room_of_scale(side_m_));
  // The middle of line x0, a side of the cell.
  const MatchingGeometry geometry_{grid_.lines[0].stations[8].position_m, {1, 0, 0}, 0.5 * side_m_};
  const std::vector<Eigen::Vector3d> stations_m_ = positions_of(grid_);
};

TEST_P(MatchingViewsOfScale, LookAcrossTheRailFromEvenBaselinesOnBothSides) {
  const Eigen::Vector3d across = direction_from_angles({0.0, 0.3});
  const MatchingViews views = choose_matching_views(geometry_, across, stations_m_);
  for (const auto& side : views.side) {
    ASSERT_THAT(side, ::testing::SizeIs(kViewsPerSide));
    for (int i = 0; i < kViewsPerSide; ++i) {
      EXPECT_NEAR(baseline_m(geometry_, across, stations_m_[side[i]]),
                  geometry_.reach_m * (i + 1) / kViewsPerSide, 1e-9 * side_m_);
    }
  }
  EXPECT_LT(stations_m_[views.side[0].front()].x() * stations_m_[views.side[1].front()].x(), 0.0);
}

TEST_P(MatchingViewsOfScale, AreDifferentStationsWithParallaxInEveryDirection) {
  for (const Eigen::Vector3d& direction : directions_around()) {
    const MatchingViews views = choose_matching_views(geometry_, direction, stations_m_);
    double longest_m = 0.0;
    std::set<int> different;
    for (const auto& side : views.side) {
      EXPECT_LE(side.size(), size_t{kViewsPerSide});
      different.insert(side.begin(), side.end());
      for (const int station : side) {
        const Eigen::Vector3d& station_m = stations_m_[station];
        longest_m = std::max(longest_m, baseline_m(geometry_, direction, station_m));
        EXPECT_LE((station_m - geometry_.reference_m).dot(direction), geometry_.reach_m)
            << "may lie behind the surface";
      }
    }
    EXPECT_EQ(different.size(), views.side[0].size() + views.side[1].size());
    EXPECT_GT(longest_m, 0.5 * geometry_.reach_m) << direction.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(CellSides, MatchingViewsOfScale, ::testing::Values(0.2, 1.0, 5.0));

TEST(MatchingViewsTest, OfASingleLineAreNoneAlongItAndOnOneSideAtItsEnd) {
  const Grid grid = synthetic_grid(line_of_scale(1.0));
  const auto views_of = [&](int station, const Eigen::Vector3d& direction) {
    return choose_matching_views({grid.station({0, station}).position_m, {1, 0, 0}, 0.5}, direction,
                                 positions_of(grid));
  };
  for (const double x : {1.0, -1.0}) {
    EXPECT_THAT(views_of(4, {x, 0, 0}).side, ::testing::Each(IsEmpty()));
  }
  EXPECT_THAT(views_of(0, {0, 0, 1}).side,
              ::testing::UnorderedElementsAre(IsEmpty(), ::testing::SizeIs(kViewsPerSide)));
}

TEST(MatchingViewsTest, DoNotDependOnTheOrderOfStations) {
  Grid grid = synthetic_grid(room_of_scale(1.0));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter_m(-0.02, 0.02);
  auto stations_m = positions_of(grid);
  for (auto& station : stations_m) {
    station += Eigen::Vector3d(jitter_m(random), jitter_m(random), jitter_m(random));
  }
  auto shuffled_m = stations_m;
  std::shuffle(shuffled_m.begin(), shuffled_m.end(), random);
  const MatchingGeometry geometry{{0.0, 0.0, -0.5}, {1, 0, 0}, 0.5};
  const auto chosen = [&](const auto& offered_m, const Eigen::Vector3d& direction) {
    std::array<std::vector<double>, 2> xs;
    const MatchingViews views = choose_matching_views(geometry, direction, offered_m);
    for (const int side : {0, 1}) {
      for (const int i : views.side[side]) xs[side].push_back(offered_m[i].x());
    }
    return xs;
  };
  for (const Eigen::Vector3d& direction : directions_around()) {
    EXPECT_EQ(chosen(stations_m, direction), chosen(shuffled_m, direction));
  }
}

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
  std::vector<int> covered(pixels_of(size).size());
  for (int tile = 0; tile < views.tiles(); ++tile) {
    for (const auto [u, v] : pixels_of({views.columns(tile), views.rows(tile)})) {
      ++covered[pixel_index(views.first_column(tile) + u, views.first_row(tile) + v, size)];
    }
    size_t compared = 0;
    for (const auto& side : views.of_tile(tile).side) {
      compared += side.size();
      for (const int i : side) {
        ASSERT_NE(views.view(i).picture, nullptr);
        EXPECT_EQ(views.view(i).to_reference_m, reference.position_m - candidates[i].position_m);
      }
    }
    EXPECT_GE(compared, 2U) << tile;
  }
  EXPECT_THAT(covered, ::testing::Each(1));
}

INSTANTIATE_TEST_SUITE_P(Widths, TilesOfSize, ::testing::Values(32, 36, 100, 128));

constexpr PanoramaSize kPictureSize{128, 64};

SyntheticRoomSpec small_line() {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.25;
  spec.scene.texture_wavelength_m = 0.5;
  return spec;
}

// Largest and mean difference of one channel of two pictures.
struct Difference {
  int most = 0;
  double mean = 0.0;
};

Difference difference_of(const StationPicture& a, const StationPicture& b, int channel) {
  Difference difference;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    const int d = std::abs(channel_of(a.samples[i], channel) - channel_of(b.samples[i], channel));
    difference.most = std::max(difference.most, d);
    difference.mean += d / static_cast<double>(a.samples.size());
  }
  return difference;
}

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
    for (int at = 0; at < reference.count; ++at) {
      const int theta = views.first_column(tile) + at / views.rows(tile);
      const int phi = views.first_row(tile) + at % views.rows(tile);
      ASSERT_EQ(channel_of(reference.samples[at], 3) == static_cast<int>(kInvalidDetail),
                theta == 21 && phi == 40);
      double green = 0.0;
      for (const int u : {2 * theta, 2 * theta + 1}) {
        for (const int v : {2 * phi, 2 * phi + 1}) {
          green += channel_of(views.reference().samples[u * 100 + v], 1);
        }
      }
      ASSERT_NEAR(channel_of(reference.samples[at], 1), green / 4.0, 0.5);
    }
  }
}

TEST(StationImageTest, HasAPanoramasColumnsAsRowsReducedByTheMean) {
  const SyntheticRoomSpec spec = small_line();
  const DepthTestRoom room(spec);
  cv::Mat frame, mean;
  cv::cvtColor(render_scene(spec.scene, room.grid().station({0, 2}).position_m, spec.width), frame,
               cv::COLOR_BGR2RGB);
  const cv::Mat full = station_image(room.room(), {0, 2}, kPictureSize);
  EXPECT_EQ(cv::norm(full, frame.t(), cv::NORM_INF), 0.0);
  cv::resize(full, mean, {32, 64}, 0.0, 0.0, cv::INTER_AREA);
  EXPECT_LE(cv::norm(station_image(room.room(), {0, 2}, {64, 32}), mean, cv::NORM_INF), 1.0);
}

TEST(StationImageTest, WrapsAroundTheSphere) {
  const DepthTestRoom room(small_line());
  const cv::Mat image = station_image(room.room(), {0, 0}, kPictureSize);
  const cv::Mat bordered = with_border(image, 5);
  ASSERT_EQ(bordered.size(), cv::Size(74, 138));
  EXPECT_EQ(bordered.at<cv::Vec3b>(4, 25), image.at<cv::Vec3b>(127, 20));
  EXPECT_EQ(bordered.at<cv::Vec3b>(133, 25), image.at<cv::Vec3b>(0, 20));
  EXPECT_EQ(bordered.at<cv::Vec3b>(25, 4), image.at<cv::Vec3b>(20, 0));
  EXPECT_EQ(bordered.at<cv::Vec3b>(25, 69), image.at<cv::Vec3b>(20, 63));
  EXPECT_EQ(cv::norm(without_border(bordered, 5), image, cv::NORM_INF), 0.0);
}

TEST(StationPictureTest, HoldsFourSamplesPerPixelAroundItsColour) {
  const DepthTestRoom room(small_line());
  const cv::Mat image = station_image(room.room(), {0, 2}, kPictureSize);
  const auto picture = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  ASSERT_EQ(picture.size, (PanoramaSize{256, 128}));
  ASSERT_EQ(picture.samples.size(), size_t{256 * 128});
  // Mean difference of each pixel's samples from those of the pixel at the given offset.
  const auto mean_difference = [&](int columns_on, int rows_on) {
    double sum = 0.0;
    for (int su = 4; su < 252; ++su) {
      for (int sv = 4; sv < 124; ++sv) {
        const MatchingSample sample = picture.samples[su * 128 + sv];
        const auto& pixel = image.at<cv::Vec3b>(su / 2 + columns_on, sv / 2 + rows_on);
        for (int c = 0; c < 3; ++c) sum += std::abs(channel_of(sample, c) - pixel[c]);
      }
    }
    return sum / (248 * 120 * 3);
  };
  const double here = mean_difference(0, 0);
  EXPECT_LT(here, 9.0);
  for (const int on : {-1, 1}) {
    EXPECT_GT(mean_difference(on, 0), 2.0 * here);
    EXPECT_GT(mean_difference(0, on), 2.0 * here);
  }
}

TEST(StationPictureTest, AppliesTheGain) {
  const DepthTestRoom room(small_line());
  const DepthTestRoom darker(small_line(), [](StationIndex, cv::Mat* frame) { *frame *= 0.7; });
  const auto expected = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  const float gain = 1.0f / 0.7f;
  const auto picture =
      make_station_picture(darker.room(), {0, 2}, kPictureSize, {{gain, gain, gain}}, {});
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_LE(difference_of(picture, expected, channel).most, 2);
  }
}

TEST(StationPictureTest, DetailIsNearlyIndependentOfExposure) {
  const DepthTestRoom room(small_line());
  const DepthTestRoom darker(small_line(), [](StationIndex, cv::Mat* frame) { *frame *= 0.6; });
  const auto bright = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  const auto dark = make_station_picture(darker.room(), {0, 2}, kPictureSize, {}, {});
  EXPECT_GT(difference_of(bright, dark, 0).mean, 30.0);
  EXPECT_LT(difference_of(bright, dark, 3).mean, 8.0);
}

}  // namespace
}  // namespace raywalk::build_lf
