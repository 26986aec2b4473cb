#include "build_lf/refine/developed_image.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/refine/refine_plan.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

constexpr StationIndex kStation{0, 8};

SyntheticRoomSpec pillar_room() {
  SyntheticRoomSpec spec;
  spec.scene.obstacle = SceneBox{{-0.15, -0.6, -0.15}, {0.15, 0.4, 0.15}};
  spec.spacing_m = 0.0625;
  spec.width = 256;
  return spec;
}

// What the station shows, developed from the sources that refine takes, with true distances.
DevelopedImage developed(const DepthTestRoom& room, const SyntheticScene& scene, int width) {
  SourceViews views(room.room());
  const Eigen::Vector3d position_m = room.grid().lines[0].stations[8].position_m;
  const InverseDistanceMap truth = true_map(scene, position_m, {width, width / 2});
  OmegaMap distances({width, width / 2});
  for (int u = 0; u < width; ++u) {
    for (int v = 0; v < width / 2; ++v) {
      distances.at(u, v) = truth.omega[pixel_index(u, v, truth.size)];
    }
  }
  std::vector<std::shared_ptr<const SourceView>> sources;
  for (const StationIndex source : sources_of(room.grid(), kStation, 3.0)) {
    sources.push_back(views.of(source));
  }
  return develop_image(room.room(), nullptr, kStation, distances, sources);
}

// The same as the scene is, [theta][phi], rgb.
cv::Mat truth_of(const DepthTestRoom& room, const SyntheticScene& scene, int width) {
  cv::Mat rgb;
  cv::cvtColor(render_scene(scene, room.grid().lines[0].stations[8].position_m, width), rgb,
               cv::COLOR_BGR2RGB);
  return rgb.t();
}

cv::Mat levels_of(const cv::Mat& developed) {
  cv::Mat levels;
  developed.convertTo(levels, CV_8U, 1.0 / kLevel);
  return levels;
}

TEST(DevelopedImageTest, ShowsEverySurfaceInItsColourAlsoBesideAPillar) {
  const SyntheticRoomSpec spec = pillar_room();
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {256, 128}, 2);
  const DevelopedImage image = developed(room, spec.scene, 512);
  const cv::Mat truth = truth_of(room, spec.scene, 512);
  EXPECT_GT(cv::PSNR(levels_of(image.colour), truth), 33.0);
  EXPECT_EQ(cv::countNonZero(image.is_known), 512 * 256);
  // Of those that other stations see: they are not far off without the own photograph.
  cv::Mat1b few;
  cv::inRange(image.others, cv::Scalar::all(0), cv::Scalar::all(0), few);
  EXPECT_LT(cv::countNonZero(few), 512 * 256 / 50);
  cv::Mat shown = levels_of(image.others);
  truth.copyTo(shown, few);
  EXPECT_GT(cv::PSNR(shown, truth), 32.0);
}

TEST(DevelopedImageTest, NoiseAveragesOut) {
  const SyntheticRoomSpec spec = room_of_scale(1.0);
  DepthTestRoom room(spec,
                     [](StationIndex station, cv::Mat* frame) { add_noise(station, 10.0, frame); });
  room.give_distances(spec.scene, {128, 64}, 2);
  const cv::Mat truth = truth_of(room, spec.scene, 128);
  const double photograph = cv::PSNR(station_image(room.room(), kStation, {128, 64}), truth);
  EXPECT_GT(cv::PSNR(levels_of(developed(room, spec.scene, 128).colour), truth), photograph + 8.0);
}

TEST(DevelopedImageTest, WhereDistancesAreUnknownItsPhotographIsShown) {
  const SyntheticRoomSpec spec = room_of_scale(1.0);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {128, 64}, 2);
  SourceViews views(room.room());
  const std::vector<std::shared_ptr<const SourceView>> sources{views.of({0, 7}), views.of({0, 9})};
  const DevelopedImage image =
      develop_image(room.room(), nullptr, kStation, OmegaMap({128, 64}), sources);
  const cv::Mat photograph = station_image(room.room(), kStation, {128, 64});
  EXPECT_EQ(cv::norm(levels_of(image.colour), photograph, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::countNonZero(image.others.reshape(1)), 0);
}

}  // namespace
}  // namespace raywalk::build_lf
