// For tests: a synthetic room in closed form, written to disk and opened, also with gains, and the
// rays and pictures of a pinhole camera in it, in double.
#pragma once

#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "core/evaluate/metrics.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "core/view/viewport.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

inline constexpr ViewMethod kViewMethods[] = {ViewMethod::kInitial, ViewMethod::kHlfVd,
                                              ViewMethod::kTwoSided};
inline constexpr ViewMethod kCorrected[] = {ViewMethod::kHlfVd, ViewMethod::kTwoSided};

// The synthetic scene's own room with stations beyond the corners.
inline SyntheticRoomSpec box_room(int width = 192) { return {.overhang_m = 0.25, .width = width}; }

// A room with a pillar in the cell, up to above the stations: lines do not see its far side nor
// what is behind it.
inline SyntheticRoomSpec pillar_spec(int width = 128) {
  return {.scene = {.obstacle = SceneBox{{0.1, -1.2, 0.12}, {0.3, 0.4, 0.32}}},
          .overhang_m = 0.25,
          .width = width,
          .distance_width = 128};
}

// Masked: every camera's directions with a y below `y`.
inline CameraCompanion masked_below(double y) {
  return {.hides = [y](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < y; }};
}

class TestRoom {
 public:
  explicit TestRoom(const SyntheticRoomSpec& spec) : spec_(spec) {
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }

  const SyntheticRoomSpec& spec() const { return spec_; }
  const Room& room() const { return room_; }

  RenderedView view(const ViewOptions& options, PlanPoint at) const {
    return Renderer(room_, options).render(at);
  }
  cv::Mat image(const ViewOptions& options, PlanPoint at) const { return view(options, at).image; }
  cv::Mat truth(PlanPoint at, int width = 0) const {
    return render_truth(spec_, at, width > 0 ? width : spec_.width);
  }
  double psnr(const ViewOptions& options, PlanPoint at) const {
    return psnr_db(image(options, at), truth(at, options.width));
  }

 private:
  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
};

// Written once per program.
inline const TestRoom& pillar_room() {
  static const TestRoom room(pillar_spec());
  return room;
}

// Largest difference of any channel of any pixel.
inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}
// Mean of the absolute differences over all channels, grey levels.
inline double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

// A room with gains, not all of them 1.
class RoomWithGains {
 public:
  RoomWithGains(const SyntheticRoomSpec& spec,
                const std::function<GainField(int line, int station)>& gains) {
    const auto path = directory_ / "room.lf";
    write_synthetic_room(spec, path);
    RoomManifest manifest = read_manifest(path);
    GainFields fields = unit_gain_fields(manifest.grid);
    for (std::size_t line = 0; line < fields.size(); ++line) {
      for (std::size_t station = 0; station < fields[line].size(); ++station) {
        fields[line][station] = gains(static_cast<int>(line), static_cast<int>(station));
      }
    }
    write_gain_fields(gains_path(path), manifest.grid, fields);
    manifest.gains = true;
    write_file_atomically(manifest_path(path), manifest_to_json(manifest));
    room_ = Room::open(path);
  }
  const Room& room() const { return room_; }

 private:
  TestDirectory directory_;
  Room room_;
};

// Other gains in every patch of every station but the first.
inline GainField random_field(int line, int station) {
  GainField field;
  if (line == 0 && station == 0) return field;  // exactly 1
  cv::RNG random(static_cast<std::uint64_t>(100 * line + station));
  field.local.create(12, 6, CV_32FC3);
  random.fill(field.local, cv::RNG::UNIFORM, 0.7, 1.3);
  return field;
}

// A viewport, angles in degrees.
inline Viewport looking(double yaw, double pitch, double roll, double fov, int width, int height) {
  return {.attitude = {radians_from_degrees(yaw), radians_from_degrees(pitch),
                       radians_from_degrees(roll)},
          .fov_x_rad = radians_from_degrees(fov),
          .width = width,
          .height = height};
}

// The unit direction in the world of a pixel of a pinhole camera.
inline Eigen::Vector3d ray_of(const Viewport& viewport, int column, int row) {
  const double focal_px = 0.5 * viewport.width / std::tan(0.5 * viewport.fov_x_rad);
  const Eigen::Vector3d ray((column + 0.5 - 0.5 * viewport.width) / focal_px,
                            -(row + 0.5 - 0.5 * viewport.height) / focal_px, 1.0);
  return (world_from_camera(viewport.attitude) * ray).normalized();
}

// The picture of a pinhole camera in a room.
inline cv::Mat true_picture(const SyntheticRoomSpec& spec, PlanPoint at, const Viewport& viewport) {
  const Eigen::Vector3d from_m(at.x_m, spec.height_m, at.z_m);
  cv::Mat picture(viewport.height, viewport.width, CV_8UC3);
  for (int u = 0; u < viewport.width; ++u) {
    for (int v = 0; v < viewport.height; ++v) {
      const Eigen::Vector3d rgb = color_at(spec.scene, from_m, ray_of(viewport, u, v));
      picture.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(rgb.z()),
                                     cv::saturate_cast<uchar>(rgb.y()),
                                     cv::saturate_cast<uchar>(rgb.x())};
    }
  }
  return picture;
}

}  // namespace raywalk
