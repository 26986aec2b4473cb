// Flat square views of a panorama, as COLMAP needs them: it has no equirectangular camera.
//
// Four horizontal faces of 90 degrees look to 45, 135, -135 and -45 degrees, so that they meet at
// the camera's front, sides and back. Every face lies in one half of the panorama: if it was
// stitched from a front and a back lens, each face was seen by one of them, and the seams run along
// edges of faces.
//
// Frames: a face's frame has x right, y up, z along its axis, like the camera's. COLMAP's world and
// camera frames are right-handed: x right, y down, z forward. F = diag(1, -1, 1) converts between
// them, in colmap_pose.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "calibrate/base/frame_poses.h"
#include "core/geometry/fisheye_lens.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

inline constexpr int kFaceCount = 4;

struct PanoramaFace {
  Eigen::Matrix3d camera_from_face = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre_m{0, 0, 0};  // of projection, in the camera's frame
};

// The centre of a face is that of its lens; without lenses it is the origin.
std::array<PanoramaFace, kFaceCount> panorama_faces(const std::optional<DualFisheyeLayout>& lenses);

// The default side of a face, pixels: 1.5 times the panorama's resolution in the middle of the face
// (COLMAP finds more features then), clamped to [384, 768]: smaller faces have too few features,
// larger ones cost time and gain little.
int default_face_px(int panorama_width);

// A pixel of a face, as COLMAP counts: the centre of the top left pixel is (0.5, 0.5).
struct FacePixel {
  double x = 0.0;
  double y = 0.0;
};

// The unit direction, in the camera's frame, at `pixel` of a face of side `face_px`; and the
// inverse, nullopt for a direction behind the face.
Eigen::Vector3d direction_of(const PanoramaFace& face, int face_px, FacePixel pixel);
std::optional<FacePixel> face_pixel_of(const PanoramaFace& face, int face_px,
                                       const Eigen::Vector3d& camera_direction);

// COLMAP's pose of a face: x_face = rotation * x_world + translation in COLMAP's frames.
struct ColmapPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation{0, 0, 0};
};
ColmapPose colmap_pose(const FramePose& camera, const PanoramaFace& face);
// Converts a point between COLMAP's world and ours (its own inverse).
Eigen::Vector3d flipped(const Eigen::Vector3d& point);

// Cuts faces from panoramas of one size. Safe to use from several threads at once.
class FaceCutter {
 public:
  FaceCutter(const std::array<PanoramaFace, kFaceCount>& faces, PanoramaSize panorama, int face_px);

  // The faces of a panorama (CV_8UC3), in grey, CV_8UC1. A panorama finer than the faces is reduced
  // first to avoid aliasing.
  std::array<cv::Mat, kFaceCount> cut(const cv::Mat& panorama) const;
  // The faces of a mask, CV_8UC1: 0 where the mask is 0 or where the direction lies within
  // `seam_deg` of the plane between the lenses, else 255.
  std::array<cv::Mat, kFaceCount> cut_mask(const cv::Mat& mask, double seam_deg) const;

 private:
  std::array<PanoramaFace, kFaceCount> faces_;
  PanoramaSize panorama_;
  PanoramaSize reduced_;  // the size that panoramas are reduced to before sampling
  int face_px_;
  std::array<std::vector<PixelPosition>, kFaceCount> sources_{};  // in the reduced panorama
};

}  // namespace raywalk::calibrate
