// For tests: a dual-fisheye camera in a virtual room, and pictures to compare panoramas with.
#pragma once

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/image_file.h"
#include "core/files/lens_file.h"
#include "core/geometry/test_pixels.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {

// Lenses that are neither equidistant nor centred, the back one rotated a little, 194 degrees each.
inline DualFisheyeCamera test_camera(int height_px, double lens_distance_m) {
  DualFisheyeCamera camera;
  camera.picture = {2 * height_px, height_px};
  camera.layout = simple_dual_fisheye(camera.picture);
  DualFisheyeLayout& layout = camera.layout;
  layout.front.k = {0.02, -0.0065, 0.0009, -0.00005};
  layout.back.k = {0.018, -0.0058, 0.0007, -0.00003};
  layout.front.largest_angle_rad = layout.back.largest_angle_rad = radians_from_degrees(97.0);
  layout.front.focal_px *= 0.95;
  layout.back.focal_px *= 0.953;
  layout.front.centre.u += 1.3;
  layout.back.centre.v -= 0.8;
  layout.back_attitude = {radians_from_degrees(-179.65), radians_from_degrees(0.3),
                          radians_from_degrees(-0.25)};
  layout.front_position_m = {0, 0, 0.5 * lens_distance_m};
  layout.back_position_m = {0, 0, -0.5 * lens_distance_m};
  return camera;
}

inline double psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& where = cv::Mat()) {
  const double pixels = where.empty() ? static_cast<double>(a.total()) : cv::countNonZero(where);
  const double squares = cv::norm(a, b, cv::NORM_L2SQR, where);
  return 10.0 * std::log10(255.0 * 255.0 * 3.0 * pixels / squares);
}

// 255 within so many degrees of the plane half way between the lenses.
inline cv::Mat near_seam(PanoramaSize size, double within_deg) {
  cv::Mat mask(size.height, size.width, CV_8UC1);
  for (const auto [u, v] : pixels_of(size)) {
    const Eigen::Vector3d direction =
        direction_from_angles(angles_from_pixel({double(u), double(v)}, size));
    const bool near = std::abs(std::asin(direction.z())) < radians_from_degrees(within_deg);
    mask.at<unsigned char>(v, u) = near ? 255 : 0;
  }
  return mask;
}

// A line of stations x0_0, x0_1, ... with these pictures of both lenses, one PNG each.
inline CaptureSet fisheye_line(const std::filesystem::path& folder,
                               std::span<const cv::Mat> pictures) {
  CaptureSet set{.source = folder, .layout = FrameLayout::kDualFisheye};
  set.frame = {pictures.front().cols, pictures.front().rows};
  set.lines = {{.id = "x0"}};
  for (const cv::Mat& picture : pictures) {
    const std::string name = "x0_" + std::to_string(set.frames.size());
    set.lines[0].frames.push_back(static_cast<int>(set.frames.size()));
    set.frames.push_back({.name = name, .file = folder / (name + ".png")});
    write_image(set.frames.back().file, picture);
  }
  return set;
}

inline const simulator::VirtualRoom& test_room() {
  static const simulator::VirtualRoom room(simulator::VirtualRoomSettings{});
  return room;
}

inline const simulator::CameraPose kTestPose{{0.1, 0.0, 0.05}, {0.3, 0.1, 0.05}};

}  // namespace raywalk::calibrate
