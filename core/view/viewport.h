// The camera of a flat picture: a pinhole camera at the viewpoint with any attitude.
#pragma once

#include "core/geometry/sphere.h"
#include "core/room/line_volume.h"

namespace raywalk {

// Pixel (i, j) looks along ((i + 0.5 - width / 2) / f, -(j + 0.5 - height / 2) / f, 1) in the
// camera's axes (right, up, forward), with f = width / 2 / tan(fov_x / 2).
struct Viewport {
  Attitude attitude{};         // world from camera
  double fov_x_rad = kHalfPi;  // of the picture's width
  int width = 0;               // pixels
  int height = 0;
};

inline constexpr double kMaxFovDeg = 170.0;
inline constexpr int kMaxViewport_px = 16384;

// Throws UsageError unless the field of view is in (0, 170] degrees, the sides in 1..16384 pixels
// and the angles within 100 turns.
void require_viewport(const Viewport& viewport);

// Pixels per radian in the picture's middle.
double focal_length_px(const Viewport& viewport);

// The columns and rows of a panorama that the samples of a viewport, also cubic ones, lie in.
struct PanoramaPart {
  int first_column = 0;  // in [0, width)
  int columns = 0;       // from there on, wrapping around the seam
  RowRun rows{};
};
PanoramaPart part_shown(const Viewport& viewport, PanoramaSize panorama);

}  // namespace raywalk
