// Poses between Raywalk and COLMAP.
//
// Raywalk's world and camera frames are left-handed: x right, y up, z forward (core/geometry/
// sphere.h). COLMAP's are right-handed; its camera looks along +z with x to the right and y down
// (colmap.github.io/format.html, "images.txt"). F = diag(1, -1, 1) converts between them, in
// colmap_pose and camera_pose_of.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/reconstruction/panorama_faces.h"

namespace raywalk {

// Where a panorama was taken, in Raywalk's frames.
struct CameraPose {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
};

// COLMAP's pose of a flat picture: x_face = rotation * x_world + translation in COLMAP's frames.
struct ColmapPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation{0, 0, 0};
};

// The pose of a face of a panorama, and the pose of the panorama of a face (without the face's
// centre_m, which has to be 0).
ColmapPose colmap_pose(const CameraPose& camera, const PanoramaFace& face);
CameraPose camera_pose_of(const ColmapPose& pose, const PanoramaFace& face);

// Converts a point between COLMAP's world and ours (its own inverse).
Eigen::Vector3d flipped(const Eigen::Vector3d& point);

}  // namespace raywalk
