// The rim of a fisheye lens's image, where the light ends.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/files/lens_file.h"

namespace raywalk::calibrate {

double distance_px(PixelPosition a, PixelPosition b);

// Which lens a pixel of a picture of both belongs to: the one whose centre is nearer.
bool belongs_to_back(const DualFisheyeLayout& layout, PixelPosition pixel);

struct ImageCircle {
  PixelPosition centre{};
  double radius_px = 0.0;
};

// Finds the circle in `brightest` (CV_8UC1, the largest level that each pixel had in several
// frames), near the circle of the start. None where half of its rim or more lies outside of the
// picture, or the light does not end on a circle.
std::optional<ImageCircle> find_image_circle(const cv::Mat& brightest,
                                             const DualFisheyeCamera& start, bool back);

// `lens` with the field of view that ends at the radius; if the lens's radius stops growing before,
// there.
FisheyeLens with_rim_at(FisheyeLens lens, double radius_px);

// The radius at which the field of view ends.
double rim_radius_px(const FisheyeLens& lens);

}  // namespace raywalk::calibrate
