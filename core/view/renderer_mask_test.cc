// Rendering with masks: the dolly that every camera sees is removed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr double kConeDeg = 22.0;
// On the floor 1.2 m below the cameras the dolly hides a disc of 0.48 m radius.
const std::vector<PlanPoint> kMaskViewpoints = {
    {0.0, 0.0}, {0.23, 0.31}, {-0.31, 0.12}, {0.5, 0.1}, {0.3, -0.5}, {-0.5, 0.5}, {0.5, -0.5}};

bool in_nadir_cone(const Eigen::Vector3d& direction, double cone_deg) {
  return -direction.y() > std::cos(radians_from_degrees(cone_deg));
}

CameraCompanion dolly() {
  return {.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
    return in_nadir_cone(direction, kConeDeg);
  }};
}

// Stands to the right of the dolly and reaches above the horizon.
CameraCompanion dolly_with_operator() {
  return {.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
    const SphereAngles angles = angles_from_direction(direction);
    const bool beside = std::fabs(angles.theta_rad - kHalfPi) < radians_from_degrees(20.0);
    return in_nadir_cone(direction, kConeDeg) ||
           (beside && angles.phi_rad < radians_from_degrees(12.0));
  }};
}

SyntheticRoomSpec with(const CameraCompanion& companion, SyntheticRoomSpec spec = box_room()) {
  spec.companion = companion;
  return spec;
}

// PSNR over what the viewpoint sees within `cone_deg` of the nadir.
double nadir_psnr_db(const cv::Mat& image, const cv::Mat& truth, double cone_deg = kConeDeg) {
  const auto rows = static_cast<int>(image.rows * cone_deg / 180.0);
  const cv::Rect nadir(0, image.rows - rows, image.cols, rows);
  return psnr_db(image(nadir).clone(), truth(nadir).clone());
}

// The largest difference between neighbours in a row, around the seam.
double largest_step_along(const cv::Mat& row) {
  cv::Mat shifted;
  cv::hconcat(row.colRange(1, row.cols), row.col(0), shifted);
  return largest_difference(row, shifted);
}

// The same room twice, with the companion in another colour: views must not depend on it.
class Recoloured {
 public:
  explicit Recoloured(const SyntheticRoomSpec& spec) : one_(spec), other_(recoloured(spec)) {}

  const TestRoom& room() const { return one_; }
  double difference(const ViewOptions& options, PlanPoint at) const {
    return largest_difference(one_.image(options, at), other_.image(options, at));
  }

 private:
  static SyntheticRoomSpec recoloured(SyntheticRoomSpec spec) {
    spec.companion->color = {0, 255, 0};
    return spec;
  }
  TestRoom one_;
  TestRoom other_;
};

TEST(RendererMask, TheDollyIsRemoved) {
  const Recoloured rooms(with(dolly(), box_room(96)));
  for (const Generation generation : kGenerations) {
    for (const PlanPoint at : kMaskViewpoints) {
      for (const double k_deg : {45.0, 76.0}) {
        EXPECT_EQ(rooms.difference({.generation = generation, .k_deg = k_deg}, at), 0.0)
            << generation_name(generation) << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

TEST(RendererMask, WithoutMasksTheDollyShows) {
  CameraCompanion unmasked = dolly();
  unmasked.masked = false;
  const Recoloured rooms(with(unmasked, box_room(96)));
  for (const Generation generation : kGenerations) {
    EXPECT_GT(rooms.difference({.generation = generation}, {0.5, 0.1}), 200.0);
  }
}

TEST(RendererMask, TheDollyIsRemovedAtAnyWidthOrNumberOfLayers) {
  SyntheticRoomSpec spec = with(dolly());
  spec.distance_width = 48;
  spec.distance_every = 3;
  const Recoloured rooms(spec);
  for (const Generation generation : kGenerations) {
    for (const int width : {64, 96, 192, 384}) {
      for (const int layers : {0, 3}) {
        const ViewOptions options{.generation = generation, .layers = layers, .width = width};
        EXPECT_EQ(rooms.difference(options, {0.45, -0.2}), 0.0)
            << generation_name(generation) << ", width " << width << ", layers " << layers;
      }
    }
  }
}

TEST(RendererMask, TheFloorBelowIsNearlyAsGoodAsWithoutADolly) {
  // Between 53 and 56 dB, against 55 and more without the dolly; at a station, a view without masks
  // would be its frame.
  const TestRoom empty(box_room());
  const TestRoom masked(with(dolly()));
  for (const Generation generation : kCorrected) {
    for (const PlanPoint at : kMaskViewpoints) {
      const ViewOptions options{.generation = generation};
      const cv::Mat truth = empty.truth(at);
      const RenderedView view = masked.view(options, at);
      EXPECT_GT(nadir_psnr_db(view.image, truth), 52.0)
          << generation_name(generation) << " at " << at.x_m << ',' << at.z_m;
      EXPECT_GT(psnr_db(view.image, truth),
                std::min(55.0, psnr_db(empty.image(options, at), truth)) - 0.3);
      EXPECT_EQ(view.report.stretched_share, 0.0);
    }
  }
}

TEST(RendererMask, CellsSmallerThanTheDollyAreFilledFromLinesBeyondThem) {
  // Every line around a cell is within 0.42 m of all of its floor.
  SyntheticRoomSpec spec = box_room(128);
  spec.cells_x = spec.cells_z = 3;
  spec.side_m = 0.3;
  spec.spacing_m = 0.1;
  spec.overhang_m = 0.2;
  const TestRoom masked(with(dolly(), spec));
  const PlanPoint at{0.05, 0.02};
  for (const Generation generation : kCorrected) {
    const RenderedView view = masked.view({.generation = generation}, at);
    EXPECT_EQ(view.report.stretched_share, 0.0) << generation_name(generation);
    EXPECT_GT(nadir_psnr_db(view.image, masked.truth(at)), 45.0) << generation_name(generation);
  }
}

TEST(RendererMask, TwoSidedViewsDoNotJumpAtALine) {
  SyntheticRoomSpec spec = box_room(128);
  spec.cells_x = 2;
  spec.side_m = 0.8;
  spec.spacing_m = 0.1;
  const TestRoom masked(with(dolly(), spec));
  constexpr double kStepM = 0.5e-6;
  const ViewOptions options{.generation = Generation::kTwoSided, .k_deg = 76.0};
  for (const double z_m : {0.1, -0.23}) {
    // The floor below comes from the far line of either cell; both show the same to less than a
    // grey level.
    EXPECT_LT(mean_difference(masked.image(options, {-kStepM, z_m}),
                              masked.image(options, {kStepM, z_m})),
              0.2);
  }
}

TEST(RendererMask, AnOperatorIsRemoved) {
  const Recoloured rooms(with(dolly_with_operator(), box_room(96)));
  for (const PlanPoint at : kMaskViewpoints) {
    for (const Generation generation : kGenerations) {
      EXPECT_EQ(rooms.difference({.generation = generation}, at), 0.0)
          << generation_name(generation) << " at " << at.x_m << ',' << at.z_m;
    }
    // No station sees what is to the right of all of them; the rest is filled.
    for (const Generation generation : kCorrected) {
      const RenderedView view = rooms.room().view({.generation = generation}, at);
      EXPECT_GT(view.report.stretched_share, 0.0);
      EXPECT_LT(view.report.stretched_share, 0.015);
      EXPECT_GT(psnr_db(view.image, rooms.room().truth(at)), 32.0);
    }
  }
}

TEST(RendererMask, ACompletelyMaskedStationIsReplaced) {
  const Recoloured rooms(
      with({.hides = [](const std::string& line, int station,
                        const Eigen::Vector3d&) { return line == "x1" && station == 6; }},
           box_room(96)));
  const TestRoom empty(box_room(96));
  const PlanPoint at{0.05, 0.2};
  for (const Generation generation : kGenerations) {
    const ViewOptions options{.generation = generation};
    EXPECT_EQ(rooms.difference(options, at), 0.0) << generation_name(generation);
    EXPECT_GT(rooms.room().psnr(options, at), empty.psnr(options, at) - 1.0);
    EXPECT_EQ(rooms.room().view(options, at).report.stretched_share, 0.0);
  }
}

TEST(RendererMask, InitialViewsFillMasksAndCountThat) {
  const TestRoom room(with(dolly()));
  const RenderedView view = room.view({.generation = Generation::kInitial}, {0.1, 0.2});
  // Rows whose centres lie in the cone.
  const int rows = static_cast<int>(std::ceil(view.image.rows * kConeDeg / 180.0 - 0.5));
  EXPECT_NEAR(view.report.stretched_share, static_cast<double>(rows) / view.image.rows, 1e-9);
  EXPECT_LT(largest_step_along(view.image.row(view.image.rows - 2)), 12.0);
  EXPECT_GT(largest_step_along(view.image.row(view.image.rows - 1 - rows)), 12.0);
}

TEST(RendererMask, PointsSeenByNoStationAreFilledAndCounted) {
  // 70 degrees: the cameras see no floor within 3.3 m of them.
  const Recoloured rooms(with(
      {.hides = [](const std::string&, int,
                   const Eigen::Vector3d& direction) { return in_nadir_cone(direction, 70.0); }},
      box_room(96)));
  for (const Generation generation : kGenerations) {
    const ViewOptions options{.generation = generation};
    EXPECT_EQ(rooms.difference(options, {0.1, 0.2}), 0.0) << generation_name(generation);
    const RenderedView view = rooms.room().view(options, {0.1, 0.2});
    EXPECT_NEAR(view.report.stretched_share, 70.0 / 180.0, 0.03);
    // Smooth across the columns, where stretched columns would be streaks.
    EXPECT_LT(largest_step_along(view.image.row(view.image.rows - 8)), 8.0);
  }
}

TEST(RendererMask, ACompletelyMaskedRoomIsMarkedEmpty) {
  const Recoloured rooms(
      with({.hides = [](const std::string&, int, const Eigen::Vector3d&) { return true; }},
           box_room(96)));
  for (const Generation generation : kGenerations) {
    const ViewOptions options{.generation = generation};
    EXPECT_EQ(rooms.difference(options, {0.1, 0.2}), 0.0) << generation_name(generation);
    EXPECT_EQ(rooms.room().view(options, {0.1, 0.2}).report.empty_share, 1.0);
  }
}

}  // namespace
}  // namespace raywalk
