// The stations of a room that are exported, and their pictures.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "build_lf/export/export_options.h"
#include "core/reconstruction/colmap_pose.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct ExportedStation {
  int line = 0;
  int station = 0;  // of the line
  std::string name{};
  Eigen::Vector3d position_m{0, 0, 0};

  // Stations of a room are in world axes.
  CameraPose pose() const { return {position_m, Eigen::Matrix3d::Identity()}; }
};

// Every n-th station of each line, with unique names, those of their files.
std::vector<ExportedStation> exported_stations(const Room& room, int every);

// The station's pixels as a transposed panorama, CV_8UC3 [theta][phi] red, green, blue; with the
// room's gains, if it has any and `gains` is set.
cv::Mat station_columns(const Room& room, int line, int station, bool gains);
// The same as a picture: CV_8UC3 BGR.
cv::Mat station_picture(const Room& room, const ExportedStation& station, bool gains);

// Whether a picture has pixels that are not to be used: masked ones, and what moved
// (core/room/distance_volume.h).
bool has_unusable_pixels(const Room& room);
// CV_8UC1 of the panorama's size, 0 = not to be used, else 255.
cv::Mat station_mask(const Room& room, const ExportedStation& station);

// "front_000.png", or ".jpg".
std::string picture_name(const ExportedStation& station, bool jpeg);
// "images/front_000.png", and "masks/front_000.png"; both relative to the export, with '/'.
std::string panorama_file(const ExportedStation& station, bool jpeg);
std::string mask_file(const ExportedStation& station);

// Writes them into an existing directory; masks only where the room has pixels that are not to be
// used, then of all stations. Throws Error.
void write_panoramas(const Room& room, const std::vector<ExportedStation>& stations,
                     const ExportOptions& options, const std::filesystem::path& directory);

}  // namespace raywalk::build_lf
