#include "build_lf/refine/developed_station.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/pack/volume_writer.h"
#include "build_lf/refine/developed_image.h"
#include "build_lf/refine/directional_mean.h"
#include "build_lf/refine/refine_plan.h"
#include "build_lf/refine/source_views.h"
#include "core/base/error.h"
#include "core/files/test_support.h"
#include "core/geometry/sphere.h"
#include "core/room/station_image.h"
#include "core/view/test_room.h"

namespace raywalk::build_lf {
namespace {

DevelopedStation station_of(bool masked) {
  DevelopedStation station;
  station.sharpening = 1.25;
  for (int i = 0; i < 8 * 4; ++i) {
    for (int c = 0; c < 3; ++c) station.rays.rays.push_back(static_cast<std::uint8_t>(3 * i + c));
    station.distances.distance_m.push_back(0.5f * static_cast<float>(i));
    station.distances.confidence.push_back(static_cast<std::uint8_t>(255 - i));
  }
  if (masked) station.rays.valid_rows.assign(16, 3);
  return station;
}

// The station in the middle of a line of a room whose maps have these confidences.
DevelopedStation developed_with(const std::function<std::uint8_t(int u, int v)>& confidence,
                                int every = 1) {
  const TestRoom made({.cells_z = 0, .distance_every = every, .stored_confidence = confidence});
  SourceViews views(made.room());
  return develop_station(made.room(), nullptr, {0, 3}, 256, &views);
}

TEST(DevelopedStationTest, SinglePixelsOfLowConfidenceAreBelieved) {
  const DevelopedStation station = developed_with(
      [](int u, int v) -> std::uint8_t { return u % 4 == 0 && v % 4 == 0 ? 20 : 255; });
  const auto& confidence = station.distances.confidence;
  EXPECT_EQ(*std::ranges::min_element(confidence), kMinConfidence);
  EXPECT_EQ(*std::ranges::max_element(confidence), 240);
  EXPECT_GT(*std::ranges::min_element(station.distances.distance_m), 1.0f);
}

TEST(DevelopedStationTest, DistancesHaveTheBitsThatViewsNeed) {
  const DevelopedStation station = developed_with([](int, int) -> std::uint8_t { return 255; });
  // 256 px: a quarter of a pixel is a 163rd of 1 m from 1 m aside, so there are 8 bits.
  std::set<float> fractions;
  for (const float metres : station.distances.distance_m) {
    int exponent = 0;
    const float fraction = 256.0f * std::frexp(metres, &exponent);
    EXPECT_EQ(fraction, std::round(fraction));
    fractions.insert(fraction);
  }
  EXPECT_GT(fractions.size(), 100u);
}

TEST(DevelopedStationTest, WhereMostAreOfLowConfidenceNoneIsKnown) {
  // The left half of the panorama.
  const DevelopedStation station =
      developed_with([](int u, int) -> std::uint8_t { return u < 64 ? 20 : 255; });
  const auto known_at = [&](std::size_t u) {
    return station.distances.confidence[u * 128 + 64] >= kMinConfidence;
  };
  for (const std::size_t u : {32u, 64u, 96u}) EXPECT_FALSE(known_at(u)) << u;
  for (const std::size_t u : {160u, 192u, 224u}) EXPECT_TRUE(known_at(u)) << u;
}

TEST(DevelopedStationTest, WithoutAMapOfItsOwnItTakesThoseAround) {
  const DevelopedStation own = developed_with([](int, int) -> std::uint8_t { return 255; });
  const DevelopedStation gathered = developed_with([](int, int) -> std::uint8_t { return 255; }, 2);
  std::size_t near = 0;
  for (std::size_t i = 0; i < own.distances.distance_m.size(); ++i) {
    const float metres = own.distances.distance_m[i];
    near += std::fabs(gathered.distances.distance_m[i] - metres) < 0.02f * metres ? 1 : 0;
  }
  EXPECT_GT(near, own.distances.distance_m.size() * 97 / 100);
}

TEST(DevelopedStationTest, IsStoredAsItIsAndDamageIsNoticed) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "a.h5";
  for (const bool masked : {false, true}) {
    const DevelopedStation station = station_of(masked);
    store_developed(file, station, "made from this");
    EXPECT_EQ(developed_rays(file).rays, station.rays.rays);
    EXPECT_EQ(developed_rays(file).valid_rows, station.rays.valid_rows);
    const StationDistances distances = developed_distances(file);
    EXPECT_EQ(distances.distance_m, station.distances.distance_m);
    EXPECT_EQ(distances.confidence, station.distances.confidence);
    EXPECT_EQ(distances.sha256,
              checksum_of_distances(station.distances.distance_m, station.distances.confidence));
    EXPECT_EQ(developed_sharpening(file), 1.25);
    EXPECT_EQ(inputs_of(file), "made from this");
  }
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_THROW(developed_rays(file), Error);
}

constexpr StationIndex kStation{0, 8};

SyntheticRoomSpec pillar_room() {
  SyntheticRoomSpec spec{.spacing_m = 0.0625, .width = 256};
  spec.scene.obstacle = SceneBox{{-0.15, -0.6, -0.15}, {0.15, 0.4, 0.15}};
  return spec;
}

// What the station shows, developed from the sources that refine takes, with true distances.
DevelopedImage developed(const DepthTestRoom& room, const SyntheticScene& scene, int width) {
  SourceViews views(room.room());
  const InverseDistanceMap truth =
      true_map(scene, room.grid().station(kStation).position_m, {width, width / 2});
  InverseMap distances({width, width / 2});
  for (const auto [u, v] : pixels_of({width, width / 2})) {
    distances.at(u, v) = truth.inverse[pixel_index(u, v, truth.size)];
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

TEST(DevelopedImageTest, WhereDistancesAreUnknownItsPhotographIsShown) {
  const SyntheticRoomSpec spec = room_of_scale(1.0);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {128, 64}, 2);
  SourceViews views(room.room());
  const std::vector<std::shared_ptr<const SourceView>> sources{views.of({0, 7}), views.of({0, 9})};
  const DevelopedImage image =
      develop_image(room.room(), nullptr, kStation, InverseMap({128, 64}), sources);
  const cv::Mat photograph = station_image(room.room(), kStation, {128, 64});
  EXPECT_EQ(cv::norm(levels_of(image.colour), photograph, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::countNonZero(image.others.reshape(1)), 0);
}

constexpr float kNear = 1.0f, kFar = 0.2f;
constexpr PanoramaSize kCoarse{128, 64};

// A disc before a wall, `turn` of a circle around the panorama.
template <typename Place>
InverseMap disc(PanoramaSize size, const Place& turn) {
  InverseMap map(size);
  for (const auto [u, v] : pixels_of(size)) {
    double across = (u + 0.5) / size.width - turn;
    across -= std::round(across);
    const double down = ((v + 0.5) / size.height - 0.5) / 2;
    map.at(u, v) = std::hypot(across, down) < 0.11 ? kNear : kFar;
  }
  return map;
}

int wrong_pixels(const InverseMap& map, const InverseMap& truth) {
  int wrong = 0;
  for (std::size_t i = 0; i < map.values().size(); ++i) {
    wrong += std::fabs(map.values()[i] - truth.values()[i]) > 0.01f ? 1 : 0;
  }
  return wrong;
}

TEST(FineMapTest, StepsAreNoStairs) {
  for (const double turn : {0.3, 0.501, 0.0}) {  // the last across the seam
    for (const int factor : {2, 4}) {
      const InverseMap truth = disc({128 * factor, 64 * factor}, turn), map = disc(kCoarse, turn);
      const int stairs = wrong_pixels(resized(map, 128 * factor), truth);
      EXPECT_LT(wrong_pixels(enlarged(map, 128 * factor), truth), stairs * 9 / 10)
          << turn << " " << factor;
    }
  }
}

TEST(FineMapTest, ALineOfAPixelStays) {
  InverseMap map = disc(kCoarse, 0.3);
  for (int v = 0; v < kCoarse.height; ++v) map.at(100, v) = kNear;
  for (const int factor : {1, 2, 3, 8}) {
    const InverseMap fine = enlarged(map, 128 * factor);
    for (int i = 0; i < factor; ++i) {
      EXPECT_EQ(fine.at(100 * factor + i, 20 * factor), kNear) << factor;
    }
    EXPECT_EQ(fine.at(100 * factor - 1, 20 * factor), kFar);
    EXPECT_EQ(fine.at(101 * factor, 20 * factor), kFar);
  }
}

TEST(FineMapTest, UnknownStaysUnknown) {
  InverseMap map = disc(kCoarse, 0.3);
  for (int u = 80; u < 90; ++u) map.at(u, 10) = map.at(u, 11) = -1.0f;
  const InverseMap fine = enlarged(map, 256);
  EXPECT_LT(fine.at(170, 22), 0.0f);
  EXPECT_EQ(fine.at(170, 30), kFar);
}

// The mean of `count` samples around `angle_rad`, of colours that `colour` gives for an angle.
template <typename Colour>
cv::Vec3f mean_of(int count, const Colour& colour) {
  DirectionalMean mean;
  for (int i = 0; i < count; ++i) {
    const float angle = 0.5f * static_cast<float>(i) / static_cast<float>(count);
    mean.add(colour(angle), 1.0f / (angle + 0.02f), angle);
  }
  return mean.value();
}

TEST(DirectionalMeanTest, ShowsAMirrorAsItIsInTheDirection) {
  const cv::Vec3f mean =
      mean_of(40, [](float angle) { return cv::Vec3f::all(angle < 0.06f ? 200.0f : 60.0f); });
  EXPECT_NEAR(mean[0], 200.0f, 1.0f);
}

TEST(DirectionalMeanTest, AFewSamplesFarAsideAreBetterThanNone) {
  DirectionalMean mean;
  EXPECT_TRUE(mean.empty());
  mean.add({10.0f, 20.0f, 30.0f}, 1e-6f, 3.0f);
  EXPECT_FALSE(mean.empty());
  EXPECT_NEAR(cv::norm(mean.value() - cv::Vec3f(10.0f, 20.0f, 30.0f)), 0.0, 1e-3);
}

TEST(DirectionalMeanTest, StaysWithinItsSamplesAtTheExtremes) {
  for (const float weight : {1e-20f, 1.0f, 1e20f}) {
    for (const float level : {0.0f, 255.0f}) {
      DirectionalMean mean;
      for (int i = 0; i < 50; ++i) {
        mean.add(cv::Vec3f::all(level), weight, static_cast<float>(i) * 0.06f);
      }
      EXPECT_NEAR(mean.value()[2], level, 1e-3) << weight;
    }
  }
}

// Whether a station sees the point on its ray in `direction` at `metres`.
bool sees(const SourceView& view, const Eigen::Vector3d& direction, double metres) {
  const PixelPosition pixel = pixel_from_angles(angles_from_direction(direction), view.size());
  return view.sees({.u = static_cast<float>(pixel.u),
                    .v = static_cast<float>(pixel.v),
                    .inverse = static_cast<float>(1.0 / metres),
                    .slack = 0.01f});
}

TEST(SourceViewsTest, AStationSeesSurfacesAndNothingBehindOrBeforeThem) {
  SyntheticRoomSpec spec{.width = 256, .distance_every = 4};
  spec.scene.obstacle = SceneBox{{-0.1, -1.0, -0.1}, {0.1, 1.0, 0.1}};
  const TestRoom room(spec);
  SourceViews views(room.room());
  // With a map and without one.
  for (const int station : {4, 5}) {
    const auto view = views.of({0, station});
    for (const Eigen::Vector3d& towards :
         {Eigen::Vector3d(0.0, 0.0, -1.0), Eigen::Vector3d(0.6, 0.0, -0.8),
          Eigen::Vector3d(-0.6, 0.48, -0.64), Eigen::Vector3d(0.0, -1.0, 0.0)}) {
      const double metres = distance_at(spec.scene, view->position_m(), towards);
      EXPECT_TRUE(sees(*view, towards, metres)) << station << ": " << towards.transpose();
      EXPECT_FALSE(sees(*view, towards, 1.3 * metres)) << station;
      EXPECT_FALSE(sees(*view, towards, metres / 1.3)) << station;
    }
    // Past the pillar's edge the wall behind it is seen, but not next to the edge, where pixels
    // mix.
    const Eigen::Vector3d to_edge = Eigen::Vector3d(0.1, 0.0, -0.1) - view->position_m();
    for (const double pixels : {-6.0, 6.0}) {
      const Eigen::AngleAxisd turn(pixels * kTwoPi / spec.width, Eigen::Vector3d::UnitY());
      const Eigen::Vector3d towards = turn * to_edge.normalized();
      EXPECT_TRUE(sees(*view, towards, distance_at(spec.scene, view->position_m(), towards)));
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
