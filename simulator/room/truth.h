// Ground truth of a virtual room: viewpoints of true views, and the files of truth.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {

struct TruthViewpoint {
  std::string name;                     // of its files
  Eigen::Vector3d position_m{0, 0, 0};  // world frame
};

// `count` viewpoints at the height of the lines, one cell after the other, spread over the grid.
// The first ten are the hard cases: the centre, four quarter points, near a corner, near two edges,
// on a line between two stations and on a station. The others are stratified random positions in a
// cell, determined by the seed. Cells in which the place is not free are passed over. A single line
// has viewpoints between its stations, half of them a little beside the line. Throws Error if a
// viewpoint has no free place in any cell.
std::vector<TruthViewpoint> truth_viewpoints(const VirtualRoom& room, int count);

// Reads a CSV table with columns name,x,z and optionally y (metres, default 0). Throws Error naming
// file and line if it has no rows, a name is not a valid file name or appears twice, or a number
// cannot be parsed.
std::vector<TruthViewpoint> read_truth_viewpoints(const std::filesystem::path& table);

// "x,y,z" in metres; "x,y,z,yaw,pitch,roll" in metres and degrees.
std::string position_fields(const Eigen::Vector3d& position_m);
std::string pose_fields(const CameraPose& pose);

// A distance map (PNG, 16-bit grey): millimetres along the ray through each pixel's centre, 0 for
// the sky, else 1 to 65535. Throws as VirtualRoom::distance_map and write_image do.
void write_distance_map(const VirtualRoom& room, const CameraPose& pose, PanoramaSize size,
                        const std::filesystem::path& file);

// From the distance map of a panorama (CV_32FC1, metres, +inf for the sky): 255 where something is
// seen that is narrower than 3 degrees across and at least a tenth nearer than what is on both
// sides of it, and in the pixels around it; else 0. CV_8UC1. So are chair legs, cords, railings.
cv::Mat thin_structures(const cv::Mat& distance_m);

// Renders noise-free ground truth views at the viewpoints into a directory that holds the
// directories gt, dist and, with `thin`, thin:
//   gt/<name>.png       the panorama, looking along z
//   dist/gt_<name>.png  its distance map
//   gt.csv              file,x,y,z,distance of all views, written last
// With `thin`, also
//   thin/<name>.png     255 where the view shows thin structures, else 0
//   gt_thin.csv         file,x,y,z,mask: the table for comparing views at thin structures only,
//                       without views that show none
// Throws Error if a viewpoint is inside furniture or a file cannot be written; Interrupted.
void write_truth_views(const VirtualRoom& room, std::span<const TruthViewpoint> viewpoints,
                       PanoramaSize size, const std::filesystem::path& directory, bool thin,
                       Progress* progress);

}  // namespace raywalk::simulator
