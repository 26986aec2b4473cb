// A dual-fisheye camera's lenses as a YAML file: written by `raywalk-calibrate lens`, read by
// whatever turns its frames into directions. configs/lenses holds examples.
#pragma once

#include <filesystem>

#include "core/geometry/fisheye_lens.h"
#include "core/geometry/sphere.h"

namespace raywalk {

struct DualFisheyeCamera {
  PanoramaSize picture{};  // pixels of one file; any proportion
  bool two_files = false;  // front and back in a file each; both lenses then have their
                           // centres in a picture of that size
  DualFisheyeLayout layout{};
};

// Keys:
//   picture_width_px, picture_height_px, two_files
//   front.centre_u_px, .centre_v_px, .focal_px, .k1 ... .k4, .largest_angle_deg,
//   front.x_mm, .y_mm, .z_mm   position in the camera's frame
//   back.…                     the same, and back.yaw_deg, .pitch_deg, .roll_deg: its attitude
//   there
// Throws UsageError as SettingsSchema does, and for a lens whose radius does not grow.
DualFisheyeCamera read_lens_file(const std::filesystem::path& file);
// Written atomically, every number with all its digits.
void write_lens_file(const std::filesystem::path& file, const DualFisheyeCamera& camera);

// The same camera in pictures of another size. Throws Error where the proportions differ.
DualFisheyeCamera scaled_to(const DualFisheyeCamera& camera, PanoramaSize picture);

}  // namespace raywalk
