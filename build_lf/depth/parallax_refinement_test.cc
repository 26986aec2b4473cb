#include "build_lf/depth/parallax_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kRefinedSize{128, 64};

// A room with known walls, a reference station and the stations compared with it.
class RefinementCase {
 public:
  explicit RefinementCase(const SyntheticRoomSpec& spec, const cv::Mat& valid = {},
                          const DepthTestRoom::Edit& edit = nullptr)
      : room_(spec, edit),
        plan_(plan_depth(room_.room(), {.every = 8})),
        gains_(unit_fields(room_.grid())),
        pictures_(room_.room(), kRefinedSize, gains_, valid, 100),
        truth_(true_map(spec.scene, reference().position_m, kRefinedSize)) {}

  const InverseDistanceMap& truth() const { return truth_; }
  // Inverse distance of a pixel of parallax at the reach.
  double pixel_per_m() const { return kTwoPi / kRefinedSize.width / plan_.reach_m; }

  // The truth with a smooth error of up to `most_px`, similar to that of the sweep's steps.
  InverseDistanceMap disturbed(double most_px) const {
    InverseDistanceMap map = truth_;
    for (size_t pixel = 0; pixel < map.omega.size(); ++pixel) {
      const double column = std::floor(static_cast<double>(pixel) / kRefinedSize.height);
      map.omega[pixel] +=
          static_cast<float>(most_px * std::sin(kTwoPi * column / 64.0) * pixel_per_m());
    }
    return map;
  }
  InverseDistanceMap refined(InverseDistanceMap map) {
    const TileViews views(reference(), candidates_near(plan_, reference()), plan_.reach_m,
                          &pictures_);
    refine_parallax(views, plan_.reach_m, &map);
    return map;
  }
  // A quantile of the errors in pixels of parallax at the reach, over some rows.
  double error_px(const InverseDistanceMap& map, double quantile, int first_row = 0,
                  int end_row = kRefinedSize.height) const {
    std::vector<double> errors_px;
    for (size_t pixel = 0; pixel < map.omega.size(); ++pixel) {
      const int row = static_cast<int>(pixel % static_cast<size_t>(kRefinedSize.height));
      if (row < first_row || row >= end_row) continue;
      errors_px.push_back(std::fabs(map.omega[pixel] - truth_.omega[pixel]) / pixel_per_m());
    }
    std::sort(errors_px.begin(), errors_px.end());
    return errors_px[static_cast<size_t>(quantile * static_cast<double>(errors_px.size() - 1))];
  }

 private:
  // The middle of the line at the back.
  const SweepReference& reference() const { return plan_.maps[1]; }

  DepthTestRoom room_;
  DepthPlan plan_;
  std::vector<std::vector<GainField>> gains_;
  PictureCache pictures_;
  InverseDistanceMap truth_;
};

SyntheticRoomSpec textured_room(double scale) {
  SyntheticRoomSpec spec = room_of_scale(scale);
  spec.scene.texture_wavelength_m = 0.5 * scale;
  return spec;
}

class RefinementOfScale : public ::testing::TestWithParam<double> {};

TEST_P(RefinementOfScale, CorrectsErrorsBelowALayer) {
  RefinementCase room(textured_room(GetParam()));
  const InverseDistanceMap before = room.disturbed(0.4);
  EXPECT_GT(room.error_px(before, 0.5), 0.25);
  const InverseDistanceMap after = room.refined(before);
  EXPECT_LT(room.error_px(after, 0.5), 0.05);
  EXPECT_LT(room.error_px(after, 0.9), 0.15);
}

TEST_P(RefinementOfScale, KeepsCorrectDistances) {
  RefinementCase room(textured_room(GetParam()));
  EXPECT_LT(room.error_px(room.refined(room.truth()), 0.9), 0.15);
}

INSTANTIATE_TEST_SUITE_P(CellSides, RefinementOfScale, ::testing::Values(0.2, 1.0, 5.0));

// Sensor noise on a plain wall is not texture.
TEST(ParallaxRefinementTest, TexturelessSurfacesAreUnchanged) {
  SyntheticRoomSpec spec = textured_room(1.0);
  spec.scene.contrast = 0.0;
  RefinementCase plain(spec);
  const InverseDistanceMap before = plain.disturbed(0.4);
  EXPECT_EQ(plain.refined(before).omega, before.omega);
  RefinementCase noisy(
      spec, {}, [](StationIndex station, cv::Mat* frame) { add_noise(station, 2.0, frame); });
  EXPECT_LT(noisy.error_px(noisy.refined(noisy.truth()), 0.9), 0.05);
}

TEST(ParallaxRefinementTest, InvalidPixelsAreUnchanged) {
  RefinementCase none(textured_room(1.0),
                      cv::Mat::zeros(kRefinedSize.height, kRefinedSize.width, CV_8UC1));
  const InverseDistanceMap before = none.disturbed(0.4);
  EXPECT_EQ(none.refined(before).omega, before.omega);
}

// A mask also blackens parts of the other stations, which must not affect the pixels beside it.
TEST(ParallaxRefinementTest, MasksDoNotAffectNeighbouringPixels) {
  constexpr int kMaskedFrom = 40;
  cv::Mat valid(kRefinedSize.height, kRefinedSize.width, CV_8UC1, cv::Scalar(255));
  valid.rowRange(kMaskedFrom, kRefinedSize.height).setTo(0);
  RefinementCase masked(textured_room(1.0), valid);
  const InverseDistanceMap after = masked.refined(masked.disturbed(0.4));
  EXPECT_LT(masked.error_px(after, 0.5, kMaskedFrom - 4, kMaskedFrom), 0.05);
  EXPECT_LT(masked.error_px(after, 0.9, kMaskedFrom - 4, kMaskedFrom), 0.15);
}

}  // namespace
}  // namespace raywalk::build_lf
