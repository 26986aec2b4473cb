// The stations of a room that are exported, and what they show.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/reconstruction/colmap_pose.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct ExportedStation {
  StationIndex index{};
  std::string name{};
  Eigen::Vector3d position_m{0, 0, 0};

  // Stations of a room are in world axes.
  CameraPose pose() const { return {position_m, Eigen::Matrix3d::Identity()}; }
  // "front_000.png", or ".jpg".
  std::string file(bool jpeg) const { return name + (jpeg ? ".jpg" : ".png"); }
};

// Every n-th station of each line, with unique names, those of their files.
std::vector<ExportedStation> exported_stations(const Room& room, int every);

// The station's pixels as a transposed panorama, CV_8UC3 [theta][phi] red, green, blue; with the
// room's gains, if it has any and `gains` is set.
cv::Mat station_columns(const Room& room, StationIndex station, bool gains);
// The same as a picture: CV_8UC3 BGR.
cv::Mat station_picture(const Room& room, StationIndex station, bool gains);
// The colour that a station shows in a direction: red, green, blue. `columns` as station_columns.
std::array<std::uint8_t, 3> colour_at(const cv::Mat& columns, const Eigen::Vector3d& direction);

// Whether a picture has pixels that are not to be used: masked ones, and what moved
// (core/room/distance_volume.h).
bool has_unusable_pixels(const Room& room);
// CV_8UC1 of the panorama's size, 0 = not to be used, else 255.
cv::Mat station_mask(const Room& room, StationIndex station);

}  // namespace raywalk::build_lf
