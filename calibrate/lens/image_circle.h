// The rim of a fisheye lens's image circle.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/files/lens_file.h"

namespace raywalk::calibrate {

double distance_px(PixelPosition a, PixelPosition b);

// Whether a pixel of a picture with both image circles is nearer to the back lens's centre.
bool belongs_to_back(const DualFisheyeLayout& layout, PixelPosition pixel);

struct ImageCircle {
  PixelPosition centre{};
  double radius_px = 0.0;
};

// Finds the circle in `brightest` (CV_8UC1, the maximum level of each pixel over several frames),
// near the circle of the start. nullopt if half of its rim or more lies outside of the picture, or
// the bright area does not end on a circle.
std::optional<ImageCircle> find_image_circle(const cv::Mat& brightest,
                                             const DualFisheyeCamera& start, bool back);

// `lens` with the field of view that ends at the radius, or where the radial model stops growing,
// if that is less.
FisheyeLens with_rim_at(FisheyeLens lens, double radius_px);

// The radius at which the field of view ends.
double rim_radius_px(const FisheyeLens& lens);

}  // namespace raywalk::calibrate
