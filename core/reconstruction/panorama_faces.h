// Flat square views of a panorama, for programs that have no equirectangular camera.
//
// A face's frame has x right, y up, z along its axis, like the camera's (core/geometry/sphere.h).
// All faces are 90 degrees wide and high.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

struct PanoramaFace {
  Eigen::Matrix3d camera_from_face = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre_m{0, 0, 0};  // of projection, in the camera's frame
};

// The six sides of a cube around the camera.
struct CubeFace {
  const char* name;   // also of the folder of its pictures
  Attitude attitude;  // of the face in the camera's frame
};
inline constexpr std::array<CubeFace, 6> kCubeFaces{
    CubeFace{"front", {0.0, 0.0, 0.0}},  CubeFace{"right", {kHalfPi, 0.0, 0.0}},
    CubeFace{"back", {kPi, 0.0, 0.0}},   CubeFace{"left", {-kHalfPi, 0.0, 0.0}},
    CubeFace{"up", {0.0, kHalfPi, 0.0}}, CubeFace{"down", {0.0, -kHalfPi, 0.0}}};
// In the order of kCubeFaces, around the origin.
std::vector<PanoramaFace> cube_faces();

// The side of a face, pixels, with the panorama's resolution in the middle of the face; even.
int native_face_px(int panorama_width);

// A pixel of a face, as COLMAP counts: the centre of the top left pixel is (0.5, 0.5).
struct FacePixel {
  double x = 0.0;
  double y = 0.0;
};

// The focal length of a face, pixels.
constexpr double face_focal_px(int face_px) { return 0.5 * face_px; }

// The unit direction, in the camera's frame, at `pixel` of a face of side `face_px`; and the
// inverse, nullopt for a direction behind the face.
Eigen::Vector3d direction_of(const PanoramaFace& face, int face_px, FacePixel pixel);
std::optional<FacePixel> face_pixel_of(const PanoramaFace& face, int face_px,
                                       const Eigen::Vector3d& camera_direction);

// Cuts faces from panoramas of one size. Safe to use from several threads at once.
class FaceCutter {
 public:
  FaceCutter(std::span<const PanoramaFace> faces, PanoramaSize panorama, int face_px);

  // The faces of a panorama (CV_8UC3), in its colours. A panorama finer than the faces is reduced
  // first to avoid aliasing.
  std::vector<cv::Mat> cut(const cv::Mat& panorama) const;
  // The faces of a mask, CV_8UC1: 0 where the mask is 0 or where the direction lies within
  // `seam_deg` of the plane between the lenses, z = 0, else 255.
  std::vector<cv::Mat> cut_mask(const cv::Mat& mask, double seam_deg) const;

 private:
  std::vector<PanoramaFace> faces_;
  PanoramaSize reduced_;  // the size that panoramas are reduced to before sampling
  int face_px_;
  std::vector<std::vector<PixelPosition>> sources_;  // in the reduced panorama
};

}  // namespace raywalk
