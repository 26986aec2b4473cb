// How the truth of a virtual room is written down, whoever captures it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

#include "capture/simulated/truth_viewpoints.h"
#include "capture/simulated/virtual_room/virtual_room.h"
#include "core/base/progress.h"

namespace raywalk::capture {

// "x,y,z" in metres; "x,y,z,yaw,pitch,roll" in metres and degrees.
std::string position_fields(const Eigen::Vector3d& position_m);
std::string pose_fields(const CameraPose& pose);

// A distance map (PNG, 16-bit grey): millimetres along the ray through each pixel's centre, 0 for
// the sky, else 1 to 65535. Throws as VirtualRoom::distance_map and write_image do.
void write_distance_map(const VirtualRoom& room, const CameraPose& pose, PanoramaSize size,
                        const std::filesystem::path& file);

// Writes what cameras at the viewpoints truly see, exact and noise-free, into a directory that
// holds the directories gt and dist:
//   gt/<name>.png       the panorama, looking along z
//   dist/gt_<name>.png  its distance map
//   gt.csv              file,x,y,z of all of them, written last
// Throws Error for a viewpoint inside of furniture, a full disk; Interrupted.
void write_truth_views(const VirtualRoom& room, std::span<const TruthViewpoint> viewpoints,
                       PanoramaSize size, const std::filesystem::path& directory,
                       Progress* progress);

}  // namespace raywalk::capture
