// Writes ground truth of a virtual room to files.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

#include "core/base/progress.h"
#include "simulator/room/truth_viewpoints.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {

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

}  // namespace raywalk::capture
