#include "core/reconstruction/colmap_pose.h"

namespace raywalk {
namespace {

// y down instead of up.
Eigen::Matrix3d flip() { return Eigen::Vector3d(1, -1, 1).asDiagonal(); }

}  // namespace

Eigen::Vector3d flipped(const Eigen::Vector3d& point) { return {point.x(), -point.y(), point.z()}; }

ColmapPose colmap_pose(const CameraPose& camera, const PanoramaFace& face) {
  const Eigen::Matrix3d world_from_face = camera.world_from_camera * face.camera_from_face;
  const Eigen::Vector3d centre_m = camera.position_m + camera.world_from_camera * face.centre_m;
  // Flipped on both sides, the determinant stays +1: a rotation in right-handed frames.
  const Eigen::Matrix3d rotation = flip() * world_from_face.transpose() * flip();
  return {Eigen::Quaterniond(rotation).normalized(), -rotation * flipped(centre_m)};
}

CameraPose camera_pose_of(const ColmapPose& pose, const PanoramaFace& face) {
  const Eigen::Matrix3d rotation = pose.rotation.normalized().toRotationMatrix();
  const Eigen::Matrix3d world_from_face = flip() * rotation.transpose() * flip();
  return {flipped(-rotation.transpose() * pose.translation),
          world_from_face * face.camera_from_face.transpose()};
}

}  // namespace raywalk
