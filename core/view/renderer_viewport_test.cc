// Flat pictures of part of a view, against the room itself and against the panorama.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/panorama/panorama_sampler.h"
#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

Viewport looking(double yaw_deg, double pitch_deg, double roll_deg, double fov_deg, int width,
                 int height) {
  return {.attitude = {radians_from_degrees(yaw_deg), radians_from_degrees(pitch_deg),
                       radians_from_degrees(roll_deg)},
          .fov_x_rad = radians_from_degrees(fov_deg),
          .width = width,
          .height = height};
}

// The picture of a pinhole camera in the scene.
cv::Mat true_picture(const SyntheticRoomSpec& spec, PlanPoint at, const Viewport& viewport) {
  const Eigen::Vector3d from_m(at.x_m, spec.height_m, at.z_m);
  cv::Mat picture(viewport.height, viewport.width, CV_8UC3);
  for (int u = 0; u < viewport.width; ++u) {
    const RayLine line = rays_of_column(viewport, u);
    for (int v = 0; v < viewport.height; ++v) {
      Eigen::Vector3d direction;
      for (int i = 0; i < 3; ++i) direction[i] = double(line.start[i]) + double(v) * line.step[i];
      const Eigen::Vector3d rgb = color_at(spec.scene, from_m, direction.normalized());
      picture.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(rgb.z()),
                                     cv::saturate_cast<uchar>(rgb.y()),
                                     cv::saturate_cast<uchar>(rgb.x())};
    }
  }
  return picture;
}

// The picture cut from a whole panorama; interpolated by cubics.
cv::Mat cut_from(const cv::Mat& panorama, const Viewport& viewport) {
  const PanoramaSampler sampler(panorama);
  cv::Mat cut(viewport.height, viewport.width, CV_8UC3);
  for (int u = 0; u < cut.cols; ++u) {
    const RayLine line = rays_of_column(viewport, u);
    for (int v = 0; v < cut.rows; ++v) {
      Eigen::Vector3d direction;
      for (int i = 0; i < 3; ++i) direction[i] = line.start[i] + v * line.step[i];
      cut.at<cv::Vec3b>(v, u) = cv::Vec3b(sampler.at(direction));
    }
  }
  return cut;
}

class ViewportRoom : public testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec;
    spec.width = 512;
    spec.overhang_m = 0.25;
    return spec;
  }
  cv::Mat flat(const ViewOptions& options, PlanPoint at, const Viewport& viewport) const {
    return Renderer(room_.room(), options).render(at, viewport).image;
  }
  const std::vector<Viewport> viewports_ = {
      looking(0, 0, 0, 90, 160, 120),      looking(180, 10, 0, 60, 101, 140),
      looking(-70, -35, 25, 100, 160, 90), looking(40, 90, 15, 80, 120, 120),
      looking(-130, -80, -60, 75, 96, 90), looking(10, 0, 90, 20, 64, 48)};

  TestRoom room_{spec()};
};

TEST_F(ViewportRoom, CorrectedPicturesMatchACamera) {
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    for (const Viewport& viewport : viewports_) {
      const PlanPoint at{0.12, -0.2};
      EXPECT_GT(psnr_db(flat({.generation = generation}, at, viewport),
                        true_picture(spec(), at, viewport)),
                36.0)
          << generation_name(generation) << " yaw " << viewport.attitude.yaw_rad;
    }
  }
}

// Up to interpolation.
TEST_F(ViewportRoom, AgreesWithThePanoramaInEveryGeneration) {
  for (const Generation generation : kGenerations) {
    for (const int layers : {0, 5}) {
      const ViewOptions options{.generation = generation, .k_deg = 76.0, .layers = layers};
      const PlanPoint at{-0.21, 0.3};
      const cv::Mat panorama = room_.image(options, at);
      for (const Viewport& viewport : viewports_) {
        const cv::Mat picture = flat(options, at, viewport);
        ASSERT_EQ(picture.size(), cv::Size(viewport.width, viewport.height));
        EXPECT_GT(psnr_db(picture, cut_from(panorama, viewport)), 40.0)
            << generation_name(generation) << layers;
      }
    }
  }
}

TEST_F(ViewportRoom, ACoarsePictureIsAFineOneAveraged) {
  const ViewOptions options{.generation = Generation::kHlfVd};
  const Viewport fine = looking(20, 5, 3, 90, 160, 128);
  const Viewport coarse = looking(20, 5, 3, 90, 40, 32);
  cv::Mat averaged;
  cv::resize(flat(options, {0.1, 0.1}, fine), averaged, {40, 32}, 0, 0, cv::INTER_AREA);
  EXPECT_LE(largest_difference(flat(options, {0.1, 0.1}, coarse), averaged), 2.0);
}

TEST_F(ViewportRoom, OneRendererAlternatesPanoramasAndPictures) {
  Renderer renderer(room_.room(), {.generation = Generation::kTwoSided});
  const cv::Mat panorama = renderer.render({0.2, 0.1}).image;
  const cv::Mat first = renderer.render({0.2, 0.1}, viewports_[2]).image;
  renderer.render({-0.4, 0.1}, viewports_[3]);
  EXPECT_EQ(largest_difference(renderer.render({0.2, 0.1}, viewports_[2]).image, first), 0.0);
  EXPECT_EQ(largest_difference(renderer.render({0.2, 0.1}).image, panorama), 0.0);
  EXPECT_THROW(renderer.render({0.2, 0.1}, looking(0, 0, 0, 180, 10, 10)), UsageError);
}

// A coarse picture is rendered finer first, up to the largest size.
TEST_F(ViewportRoom, NarrowPicturesOfAWideFieldRender) {
  const cv::Mat picture =
      flat({.generation = Generation::kInitial}, {0.1, 0.1}, looking(0, 0, 0, 170, 1, 4000));
  EXPECT_EQ(picture.size(), cv::Size(1, 4000));
}

// Where no station sees a point, rows outside the requested ones may be the source of stretched
// rows: here no fill stations are used, and maps that contradict each other hide much.
TEST(WantedRows, EqualThoseOfTheWholeColumn) {
  SyntheticRoomSpec spec;
  spec.width = 256;
  spec.overhang_m = 0.25;
  spec.distance_width = 64;
  spec.stored_distance = [](int u, int v, double exact_m) {
    return static_cast<float>((u / 2 + v / 2) % 2 == 0 ? exact_m : 0.1 * exact_m);
  };
  const TestRoom room(spec);
  std::int64_t stretched = 0;
  for (const Generation generation : kGenerations) {
    Renderer renderer(room.room(), {.generation = generation});
    const ViewInputs& prepared = renderer.prepare({0.1, -0.2}).inputs();
    const auto inputs = [&](RowRun rows) {
      return ViewInputs{.room = prepared.room,
                        .plan = prepared.plan,
                        .output = prepared.output,
                        .rows = rows,
                        .distances = prepared.distances,
                        .layers = prepared.layers,
                        .fill_maps = {}};
    };
    const ViewInputs whole = inputs({0, prepared.output.height});
    for (const RowRun rows : {RowRun{10, 40}, {50, 51}, {70, 128}}) {
      const ViewInputs wanted = inputs(rows);
      ColumnRenderer all(whole), part(wanted);
      for (int u = 0; u < 256; ++u) {
        const double theta_rad = angles_from_pixel({double(u), 0.0}, whole.output).theta_rad;
        const auto sources = renderer.sources(whole.plan.column(theta_rad));
        std::vector<std::uint8_t> expected(3 * 128 + 4), found(3 * 128 + 4, 0xAA);
        all.render(u, sources, expected.data());
        part.render(u, sources, found.data());
        ASSERT_TRUE(std::equal(expected.begin() + 3 * rows.begin, expected.begin() + 3 * rows.end,
                               found.begin() + 3 * rows.begin))
            << generation_name(generation) << " column " << u << " rows from " << rows.begin;
      }
      stretched += all.counts().stretched;
    }
  }
  EXPECT_GT(stretched, 1000);
}

// A room whose cameras see nothing of directions with a y below `y`.
SyntheticRoomSpec masked_below(double y) {
  SyntheticRoomSpec spec;
  spec.width = 256;
  spec.overhang_m = 0.25;
  spec.companion.emplace().hides = [y](const std::string&, int, const Eigen::Vector3d& d) {
    return d.y() < y;
  };
  return spec;
}

TEST(ViewportMasks, TheDollyIsNotShown) {
  const TestRoom room(masked_below(-0.8));
  for (const Generation generation : kGenerations) {
    Renderer renderer(room.room(), {.generation = generation});
    for (const double pitch_deg : {-90.0, -60.0, -30.0}) {
      const cv::Mat picture =
          renderer.render({0.1, 0.2}, looking(30, pitch_deg, 0, 80, 90, 90)).image;
      cv::Mat magenta;
      cv::inRange(picture, cv::Scalar(200, 0, 200), cv::Scalar(255, 60, 255), magenta);
      EXPECT_EQ(cv::countNonZero(magenta), 0) << generation_name(generation) << pitch_deg;
    }
  }
}

// Of a large place that no station shows a flat picture may see a part only; it is filled as in the
// panorama.
TEST(ViewportMasks, WhatNoStationShowsIsFilledAsInThePanorama) {
  const TestRoom room(masked_below(-0.4));
  for (const Generation generation : kGenerations) {
    Renderer renderer(room.room(), {.generation = generation});
    const cv::Mat panorama = renderer.render({0.1, 0.2}).image;
    for (const double pitch_deg : {-90.0, -55.0, -30.0}) {
      const Viewport viewport = looking(30, pitch_deg, 0, 50, 60, 60);
      EXPECT_GT(psnr_db(renderer.render({0.1, 0.2}, viewport).image, cut_from(panorama, viewport)),
                40.0)
          << generation_name(generation) << pitch_deg;
    }
  }
}

}  // namespace
}  // namespace raywalk
