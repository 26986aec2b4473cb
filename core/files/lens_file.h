// The lenses of a dual-fisheye camera as a YAML file, written by `raywalk-calibrate lens`.
// Examples: configs/lenses.
#pragma once

#include <filesystem>
#include <string>

#include "core/geometry/fisheye_lens.h"
#include "core/geometry/sphere.h"

namespace raywalk {

struct DualFisheyeCamera {
  PanoramaSize picture{};  // pixels of one file; any aspect ratio
  bool two_files = false;  // one file per lens; both lenses then have their
                           // centres in an image of that size
  DualFisheyeLayout layout{};
  // Of the light on a lens's axis exp(falloff_2 t^2 + falloff_4 t^4) arrives at the angle t,
  // radians: even by symmetry, and never 0.
  double falloff_2 = 0.0;
  double falloff_4 = 0.0;
};

// The share of the light on a lens's axis that arrives at an angle, radians.
double light_share(const DualFisheyeCamera& camera, double angle_rad);

// Keys:
//   picture_width_px, picture_height_px, two_files, falloff_2, falloff_4
//   front.centre_u_px, .centre_v_px, .focal_px, .k1 ... .k4, .largest_angle_deg,
//   front.x_mm, .y_mm, .z_mm   position in the camera's frame
//   back.…                     the same, and its attitude in the camera's frame:
//                              back.yaw_deg, .pitch_deg, .roll_deg
// Throws UsageError as SettingsSchema does, and if a lens fails require_monotonic_radius
// (fisheye_lens.h).
DualFisheyeCamera read_lens_file(const std::filesystem::path& file);
// Its text, with numbers in full precision.
std::string lens_file_text(const DualFisheyeCamera& camera);
// Written atomically. Throws Error if it cannot be written.
void write_lens_file(const std::filesystem::path& file, const DualFisheyeCamera& camera);

// The same camera for images of another size. Throws Error if the aspect ratios differ.
DualFisheyeCamera scaled_to(const DualFisheyeCamera& camera, PanoramaSize picture);

}  // namespace raywalk
