// Views with the parameters that choose the samples of a pixel: linear or cubic, of how many
// stations.
#include <gtest/gtest.h>

#include "core/view/renderer.h"
#include "core/view/test_room.h"
#include "core/view/test_viewport.h"

namespace raywalk {
namespace {

// Texture with a wavelength of a few pixels, whose crests linear interpolation flattens.
SyntheticRoomSpec textured_room(int width = 192) {
  SyntheticRoomSpec spec = box_room(width);
  spec.scene.texture_wavelength_m = 0.5;
  return spec;
}

TEST(RendererInterpolation, CubicIsCloserToTheTruthThanLinear) {
  const TestRoom room(textured_room());
  for (const ViewMethod method : kCorrected) {
    for (const PlanPoint at : {PlanPoint{0.13, -0.21}, {-0.31, 0.17}}) {
      const ViewOptions linear{.method = method};
      const ViewOptions cubic{.method = method, .interpolation = Interpolation::kCubic};
      EXPECT_GT(room.psnr(cubic, at), room.psnr(linear, at) + 1.0) << method_name(method);
    }
  }
}

TEST(RendererInterpolation, InitialViewsAndFlatPicturesAreResampledWithIt) {
  SyntheticRoomSpec spec = textured_room();
  spec.scene.infinitely_far = true;
  const TestRoom room(spec);
  const ViewOptions linear{.method = ViewMethod::kInitial, .width = 300};
  ViewOptions cubic = linear;
  cubic.interpolation = Interpolation::kCubic;
  EXPECT_GT(room.psnr(cubic, {0.1, 0.2}), room.psnr(linear, {0.1, 0.2}) + 1.0);
  // At the captured width columns are copied either way.
  const ViewOptions copied{.method = ViewMethod::kInitial};
  cubic.width = 0;
  EXPECT_EQ(largest_difference(room.image(copied, {0.1, 0.2}), room.image(cubic, {0.1, 0.2})), 0.0);
  // Across the seam, over the zenith, and straight: parts of the panorama and all of it.
  for (const Viewport& viewport : {looking(170, 10, 20, 57, 70, 45), looking(0, 80, 0, 57, 70, 45),
                                   looking(0, 0, 0, 57, 70, 45)}) {
    cv::Mat truth(viewport.height, viewport.width, CV_8UC3);
    for (int v = 0; v < truth.rows; ++v) {
      for (int u = 0; u < truth.cols; ++u) {
        const Eigen::Vector3d rgb = color_at(spec.scene, {0, 0, 0}, ray_of(viewport, u, v));
        truth.at<cv::Vec3b>(v, u) = cv::Vec3b(cv::Vec3d(rgb.z(), rgb.y(), rgb.x()));
      }
    }
    const auto psnr = [&](const ViewOptions& options) {
      Renderer renderer(room.room(), options);
      // Another picture first, so that leftovers in memory would show.
      renderer.render({0.1, 0.2}, looking(0, -57, 0, 90, 50, 50));
      return psnr_db(renderer.render({0.1, 0.2}, viewport).image, truth);
    };
    EXPECT_GT(psnr(cubic), psnr(copied) + 1.0);
  }
}

TEST(RendererStations, AnyNumberOfThemStaysCloseToTheTruth) {
  const TestRoom room(textured_room());
  const PlanPoint at{0.13, -0.21};
  for (const ViewMethod method : kCorrected) {
    const double one_db = room.psnr({.method = method}, at);
    EXPECT_GT(one_db, 30.0);
    for (const int stations : {2, 5, 16}) {
      EXPECT_NEAR(room.psnr({.method = method, .stations_mixed = stations}, at), one_db, 3.0)
          << method_name(method) << ' ' << stations;
    }
  }
}

}  // namespace
}  // namespace raywalk
