// Views with the parameters that choose the samples of a pixel: nearest, linear or cubic, of one
// station or two.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr Interpolation kWays[] = {Interpolation::kNearest, Interpolation::kLinear,
                                   Interpolation::kCubic};

// Texture with a wavelength of a few pixels, whose crests linear interpolation flattens.
SyntheticRoomSpec textured_room(int width = 192) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = width;
  spec.scene.texture_wavelength_m = 0.5;
  return spec;
}

// Each interpolation, from nearest to cubic, is closer to the truth than the one before.
void expect_increasing(const std::array<double, 3>& psnr_db, const std::string& what) {
  EXPECT_GT(psnr_db[1], psnr_db[0] + 1.0) << what;
  EXPECT_GT(psnr_db[2], psnr_db[1] + 1.0) << what;
}

TEST(RendererInterpolation, QualityRisesFromNearestToLinearToCubic) {
  const TestRoom room(textured_room());
  for (const Generation generation : kCorrected) {
    for (const PlanPoint at : {PlanPoint{0.13, -0.21}, {-0.31, 0.17}}) {
      std::array<double, 3> psnr_db{};
      for (const Interpolation way : kWays) {
        psnr_db[static_cast<size_t>(way)] =
            room.psnr({.generation = generation, .interpolation = way}, at);
      }
      expect_increasing(psnr_db, generation_name(generation));
    }
  }
}

TEST(RendererInterpolation, InitialViewsAreResampledWithTheInterpolation) {
  SyntheticRoomSpec spec = textured_room();
  spec.scene.infinitely_far = true;
  const TestRoom room(spec);
  std::array<double, 3> psnr_db{};
  for (const Interpolation way : kWays) {
    psnr_db[static_cast<size_t>(way)] = room.psnr(
        {.generation = Generation::kInitial, .width = 300, .interpolation = way}, {0.1, 0.2});
  }
  expect_increasing(psnr_db, "initial at another width");
  // At the captured width they are copied with every interpolation.
  EXPECT_EQ(largest_difference(room.image({.generation = Generation::kInitial}, {0.1, 0.2}),
                               room.image({.generation = Generation::kInitial,
                                           .interpolation = Interpolation::kCubic},
                                          {0.1, 0.2})),
            0.0);
}

// The exact flat picture.
cv::Mat flat_truth(const SyntheticRoomSpec& spec, const Viewport& viewport) {
  const Eigen::Matrix3d turn = world_from_camera(viewport.attitude);
  const double focal_px = 0.5 * viewport.width / std::tan(0.5 * viewport.fov_x_rad);
  cv::Mat truth(viewport.height, viewport.width, CV_8UC3);
  for (int row = 0; row < truth.rows; ++row) {
    for (int column = 0; column < truth.cols; ++column) {
      const Eigen::Vector3d ray((column + 0.5 - 0.5 * viewport.width) / focal_px,
                                -(row + 0.5 - 0.5 * viewport.height) / focal_px, 1.0);
      const Eigen::Vector3d rgb = color_at(spec.scene, {0, 0, 0}, (turn * ray).normalized());
      truth.at<cv::Vec3b>(row, column) = {cv::saturate_cast<std::uint8_t>(rgb.z()),
                                          cv::saturate_cast<std::uint8_t>(rgb.y()),
                                          cv::saturate_cast<std::uint8_t>(rgb.x())};
    }
  }
  return truth;
}

TEST(RendererInterpolation, FlatPicturesAreReadWithTheInterpolation) {
  SyntheticRoomSpec spec = textured_room();
  spec.scene.infinitely_far = true;
  const TestRoom room(spec);
  // Across the seam, over the zenith, and straight: parts of the panorama and all of it.
  for (const Attitude& turn : {Attitude{.yaw_rad = 3.0, .pitch_rad = 0.2, .roll_rad = 0.3},
                               Attitude{.pitch_rad = 1.4}, Attitude{}}) {
    const Viewport viewport{.attitude = turn, .fov_x_rad = 1.0, .width = 70, .height = 45};
    std::array<double, 3> psnr_db{};
    for (const Interpolation way : kWays) {
      Renderer renderer(room.room(), {.generation = Generation::kInitial, .interpolation = way});
      // Another picture first, so that leftovers in memory would show.
      renderer.render({0.1, 0.2}, {.attitude = {.pitch_rad = -1.0}, .width = 50, .height = 50});
      psnr_db[static_cast<size_t>(way)] =
          raywalk::psnr_db(renderer.render({0.1, 0.2}, viewport).image, flat_truth(spec, viewport));
    }
    expect_increasing(psnr_db, "flat");
  }
}

using CapturedColor = std::array<std::uint8_t, 3>;

std::set<CapturedColor> captured_colors(const Room& room) {
  std::set<CapturedColor> colors;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const LineVolume& volume = room.volume(line);
    for (int station = 0; station < volume.stations(); ++station) {
      for (int theta = 0; theta < volume.panorama().width; ++theta) {
        const auto column = volume.column(station, theta);
        for (size_t i = 0; i < column.size(); i += 3) {
          colors.insert({column[i], column[i + 1], column[i + 2]});
        }
      }
    }
  }
  return colors;
}

// Number of pixels whose colour was never captured.
int invented_pixels(const cv::Mat& image, const std::set<CapturedColor>& captured) {
  int invented = 0;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const auto& bgr = image.at<cv::Vec3b>(row, column);
      invented += captured.count({bgr[2], bgr[1], bgr[0]}) == 0;
    }
  }
  return invented;
}

TEST(RendererInterpolation, NearestOfOneStationShowsStoredPixelsOnly) {
  const TestRoom room(textured_room(64));
  const std::set<CapturedColor> captured = captured_colors(room.room());
  for (const int width : {64, 100}) {
    ViewOptions options{.overlap_deg = 0.0,
                        .width = width,
                        .interpolation = Interpolation::kNearest,
                        .stations_mixed = 1};
    EXPECT_EQ(invented_pixels(room.image(options, {0.13, -0.21}), captured), 0);
    options.interpolation = Interpolation::kLinear;
    EXPECT_GT(invented_pixels(room.image(options, {0.13, -0.21}), captured), 100);
  }
}

TEST(RendererInterpolation, ExtremesRenderWithEveryInterpolation) {
  SyntheticRoomSpec spec = textured_room(32);
  for (const auto& metres : {std::pair{1e-6f, 1e8f}, {2.0f, 0.0f}}) {
    spec.stored_distance = [metres](int u, int v, double) {
      return (u / 2 + v / 2) % 2 == 0 ? metres.first : metres.second;
    };
    for (const int distance_width : {32, 16, 24}) {
      spec.distance_width = distance_width;
      const TestRoom room(spec);
      for (const Generation generation : kGenerations) {
        for (const Interpolation way : kWays) {
          for (const int stations : {1, 2}) {
            for (const int width : {4, 20, 32, 64}) {
              for (const PlanPoint at : {PlanPoint{0.5, 0.5}, {-0.5, 0.1}, {0.2, 0.0}}) {
                const RenderedView view = room.view({.generation = generation,
                                                     .width = width,
                                                     .interpolation = way,
                                                     .stations_mixed = stations},
                                                    at);
                EXPECT_EQ(view.image.size(), cv::Size(width, width / 2));
                EXPECT_EQ(view.report.empty_share, 0.0);
              }
            }
          }
        }
      }
    }
  }
}

TEST(RendererInterpolation, TheSmallestPanoramasAreReadWithEveryInterpolation) {
  // Two rows: each is a pole's.
  SyntheticRoomSpec spec = textured_room(4);
  spec.scene.contrast = 0.0;
  const TestRoom room(spec);
  for (const Generation generation : kGenerations) {
    for (const Interpolation way : kWays) {
      const cv::Mat view =
          room.image({.generation = generation, .width = 16, .interpolation = way}, {0.1, 0.2});
      EXPECT_EQ(largest_difference(view, cv::Mat(8, 16, CV_8UC3, cv::Scalar::all(128))), 0.0);
    }
  }
}

// Hides the floor around the camera and what is to its right, up to above the horizon.
CameraCompanion operator_beside_dolly() {
  return {.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
    const SphereAngles angles = angles_from_direction(direction);
    const bool beside = std::fabs(angles.theta_rad - kHalfPi) < radians_from_degrees(20.0);
    return direction.y() < -0.9 || (beside && angles.phi_rad < radians_from_degrees(12.0));
  }};
}

TEST(RendererInterpolation, NothingMaskedIsReadWithAnyInterpolation) {
  for (const int distance_width : {96, 48, 64}) {
    SyntheticRoomSpec spec = textured_room(96);
    spec.companion = operator_beside_dolly();
    spec.distance_width = distance_width;
    const TestRoom room(spec);
    spec.companion->color = {0, 255, 0};
    const TestRoom recoloured(spec);
    for (const Generation generation : kGenerations) {
      for (const Interpolation way : kWays) {
        for (const int stations : {1, 2}) {
          for (const int width : {96, 64, 192}) {
            const ViewOptions options{.generation = generation,
                                      .width = width,
                                      .interpolation = way,
                                      .stations_mixed = stations};
            EXPECT_EQ(largest_difference(room.image(options, {0.23, 0.31}),
                                         recoloured.image(options, {0.23, 0.31})),
                      0.0)
                << generation_name(generation) << ", " << interpolation_name(way) << ", width "
                << width << ", stations " << stations;
          }
        }
      }
    }
  }
}

// Columns all of whose sources lie at a station.
std::vector<int> columns_at_stations(Renderer* renderer, PlanPoint at, int width) {
  const PreparedView& view = renderer->prepare(at);
  std::vector<int> columns;
  for (int u = 0; u < width; ++u) {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, {width, width / 2}).theta_rad;
    const auto sources = renderer->sources(view.plan().column(theta_rad));
    if (std::ranges::all_of(sources, [](const RaySource& source) {
          return std::fabs(source.fraction - std::round(source.fraction)) < 1e-6;
        })) {
      columns.push_back(u);
    }
  }
  return columns;
}

TEST(RendererStations, OneEqualsTwoExactlyAtAStation) {
  const TestRoom room(textured_room());
  const PlanPoint at_station{0.125, 0.5};  // on the front line
  for (const Generation generation : {Generation::kInitial, Generation::kHlfVd}) {
    Renderer renderer(room.room(), {.generation = generation});
    const cv::Mat two = renderer.render(at_station).image;
    const auto columns = columns_at_stations(&renderer, at_station, two.cols);
    EXPECT_GT(columns.size(), 80u);
    const cv::Mat one = room.image({.generation = generation, .stations_mixed = 1}, at_station);
    for (const int u : columns) ASSERT_EQ(largest_difference(one.col(u), two.col(u)), 0.0) << u;
    EXPECT_GT(largest_difference(one, two), 0.0);
  }
}

TEST(RendererStations, OneReadsHalfTheSamplesAndStaysCloseToTheTruth) {
  const TestRoom room(textured_room());
  const PlanPoint at{0.13, -0.21};
  for (const Generation generation : kGenerations) {
    const RenderedView two = room.view({.generation = generation}, at);
    const RenderedView one = room.view({.generation = generation, .stations_mixed = 1}, at);
    EXPECT_EQ(2 * one.report.work.samples, two.report.work.samples) << generation_name(generation);
    EXPECT_EQ(one.report.work.readings, two.report.work.readings);
    if (generation != Generation::kInitial) {
      EXPECT_GT(psnr_db(one.image, room.truth(at)), psnr_db(two.image, room.truth(at)) - 1.0);
    }
  }
}

TEST(RendererStations, InitialViewsOfOneStationAreCopiedColumns) {
  const TestRoom room(textured_room(64));
  const PlanPoint at{0.13, -0.21};
  const ViewOptions options{
      .generation = Generation::kInitial, .overlap_deg = 0.0, .stations_mixed = 1};
  Renderer renderer(room.room(), options);
  const cv::Mat image = renderer.render(at).image;
  for (int u = 0; u < image.cols; ++u) {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, {64, 32}).theta_rad;
    const RaySource source = renderer.prepare(at).plan().column(theta_rad).front[0];
    const int nearer = source.station + (source.fraction < 0.5 ? 0 : 1);
    const auto column = room.room().volume(source.line).column(nearer, u);
    for (int v = 0; v < image.rows; ++v) {
      const std::uint8_t* rgb = column.data() + 3 * v;
      ASSERT_EQ(image.at<cv::Vec3b>(v, u), cv::Vec3b(rgb[2], rgb[1], rgb[0]));
    }
  }
}

}  // namespace
}  // namespace raywalk
