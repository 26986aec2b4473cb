// Views of rooms that people walked through: what only some stations show is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

const std::vector<PlanPoint> kViewpoints = {{0.0, 0.0}, {0.23, 0.31}, {-0.31, 0.12}, {0.3, -0.5}};

// Someone in magenta in front of a few stations of each line.
CameraCompanion visitor() {
  return {.hides =
              [](const std::string&, int station, const Eigen::Vector3d& direction) {
                const SphereAngles angles = angles_from_direction(direction);
                const double towards = 0.8 * (station % 8) - 3.0;
                return station % 4 == 1 && std::fabs(angles.theta_rad - towards) < 0.35 &&
                       angles.phi_rad < 0.2;
              },
          .masked = false,
          .left_out = true};
}

SyntheticRoomSpec room_with(const CameraCompanion& companion, int width = 96) {
  SyntheticRoomSpec spec = box_room(width);
  spec.companion = companion;
  return spec;
}

SyntheticRoomSpec in_green(SyntheticRoomSpec spec) {
  spec.companion->color = {0, 255, 0};
  return spec;
}

TEST(RendererLeftOut, VisitorsDoNotShow) {
  for (const int distance_width : {96, 48}) {
    SyntheticRoomSpec spec = room_with(visitor());
    spec.distance_width = distance_width;
    const TestRoom room(spec);
    const TestRoom other(in_green(spec));
    SyntheticRoomSpec empty = spec;
    empty.companion.reset();
    const TestRoom nobody(empty);
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : kViewpoints) {
        const ViewOptions options{.generation = generation};
        EXPECT_EQ(largest_difference(room.image(options, at), other.image(options, at)), 0.0)
            << generation_name(generation) << " at " << at.x_m << ',' << at.z_m;
        EXPECT_GT(room.psnr(options, at), nobody.psnr(options, at) - 1.0);
      }
    }
  }
}

TEST(RendererLeftOut, UnrecordedVisitorsShow) {
  CameraCompanion unrecorded = visitor();
  unrecorded.left_out = false;
  const TestRoom room(room_with(unrecorded));
  for (const Generation generation : kCorrected) {
    EXPECT_LT(room.psnr({.generation = generation}, {0.23, 0.31}), 30.0);
  }
}

TEST(RendererLeftOut, AreUsedWhereNoOtherStationSeesThePlace) {
  CameraCompanion everywhere = visitor();
  everywhere.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
    return direction.y() < -0.5;
  };
  const TestRoom room(room_with(everywhere));
  for (const Generation generation : kCorrected) {
    const RenderedView view = room.view({.generation = generation}, {0.1, 0.1});
    EXPECT_EQ(view.report.stretched_share, 0.0);
    const auto below = view.image.at<cv::Vec3b>(view.image.rows - 4, 10);
    EXPECT_EQ(below, cv::Vec3b(255, 0, 255));
  }
}

TEST(RendererLeftOut, AreThoseOfTheKeptStationsInAThinnedRoom) {
  const SyntheticRoomSpec spec = room_with(visitor());
  const TestRoom room(spec);
  const TestRoom other(in_green(spec));
  const ViewOptions options{.generation = Generation::kTwoSided, .station_stride = 2};
  EXPECT_EQ(largest_difference(room.image(options, {0.1, 0.2}), other.image(options, {0.1, 0.2})),
            0.0);
}

}  // namespace
}  // namespace raywalk
