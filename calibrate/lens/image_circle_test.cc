#include "calibrate/lens/image_circle.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibrate/lens/lens_test_camera.h"

namespace raywalk::calibrate {
namespace {

constexpr PanoramaSize kPicture{1120, 560};

// Bright discs in the fields of view of the true lenses.
cv::Mat lit_circles(const DualFisheyeLayout& layout, double level) {
  cv::Mat picture(kPicture.height, kPicture.width, CV_8UC1, cv::Scalar(2));
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const PixelPosition at{static_cast<double>(u), static_cast<double>(v)};
      const bool back = belongs_to_back(layout, at);
      if (unproject(back ? layout.back : layout.front, at)) {
        picture.at<uchar>(v, u) = cv::saturate_cast<uchar>(level);
      }
    }
  }
  return picture;
}

TEST(ImageCircleTest, RimIsFoundDespiteDarkObjectsNearIt) {
  const DualFisheyeCamera truth = true_camera(kPicture), start = plain_camera(kPicture);
  cv::Mat picture = lit_circles(truth.layout, 180.0);
  cv::rectangle(picture, {240, 430, 90, 130}, cv::Scalar(3), cv::FILLED);  // a pole, to the rim
  for (const bool back : {false, true}) {
    const FisheyeLens& lens = back ? truth.layout.back : truth.layout.front;
    const auto circle = find_image_circle(picture, start, back);
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->centre.u, lens.centre.u, 0.5);
    EXPECT_NEAR(circle->centre.v, lens.centre.v, 0.5);
    EXPECT_NEAR(circle->radius_px, rim_radius_px(lens), 0.7);
  }
}

TEST(ImageCircleTest, NoCircleIsFoundWithoutARim) {
  const DualFisheyeCamera start = plain_camera(kPicture);
  const cv::Mat lit_all_over(kPicture.height, kPicture.width, CV_8UC1, cv::Scalar(180));
  EXPECT_FALSE(find_image_circle(lit_all_over, start, false));
  EXPECT_FALSE(find_image_circle(lit_circles(start.layout, 8.0), start, false));  // night
}

TEST(ImageCircleTest, FieldOfViewEndsAtTheRimOrWhereTheRadiusStopsGrowing) {
  const FisheyeLens truth = true_camera(kPicture).layout.front;
  FisheyeLens lens = truth;
  lens.largest_angle_rad = 0.3;
  EXPECT_NEAR(with_rim_at(lens, rim_radius_px(truth)).largest_angle_rad, truth.largest_angle_rad,
              2e-4);
  lens.k = {-0.2, 0.0, 0.0, 0.0};  // grows up to t = sqrt(1 / 0.6)
  const FisheyeLens folded = with_rim_at(lens, 1e6);
  EXPECT_NEAR(folded.largest_angle_rad, std::sqrt(1.0 / 0.6), 2e-4);
  EXPECT_NO_THROW(require_monotonic_radius(folded));
}

}  // namespace
}  // namespace raywalk::calibrate
