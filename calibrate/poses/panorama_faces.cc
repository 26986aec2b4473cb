#include "calibrate/poses/panorama_faces.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {
namespace {

constexpr std::array<double, kFaceCount> kFaceYaw_deg{45.0, 135.0, -135.0, -45.0};
constexpr int kSmallestFace_px = 384;
constexpr int kLargestFace_px = 768;

// y down instead of up.
Eigen::Matrix3d flip() { return Eigen::Vector3d(1, -1, 1).asDiagonal(); }

// A face of 90 degrees is as wide as twice its focal length.
double focal_px(int face_px) { return 0.5 * face_px; }

// The side of a face with the panorama's resolution in its middle: W / 2 pi = face_px / 2.
int native_width(int face_px) { return static_cast<int>(std::ceil(kPi * face_px / 2.0)) * 2; }

}  // namespace

std::array<PanoramaFace, kFaceCount> panorama_faces(
    const std::optional<DualFisheyeLayout>& lenses) {
  std::array<PanoramaFace, kFaceCount> faces{};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double yaw_rad = radians_from_degrees(kFaceYaw_deg[i]);
    faces[i].camera_from_face = world_from_camera({yaw_rad, 0.0, 0.0});
    const bool front = std::abs(yaw_rad) < kHalfPi;
    if (lenses) faces[i].centre_m = front ? lenses->front_position_m : lenses->back_position_m;
  }
  return faces;
}

int default_face_px(int panorama_width) {
  return std::clamp(panorama_width / 2, kSmallestFace_px, kLargestFace_px);
}

Eigen::Vector3d direction_of(const PanoramaFace& face, int face_px, FacePixel pixel) {
  const double middle = 0.5 * face_px;
  const Eigen::Vector3d in_face(pixel.x - middle, middle - pixel.y, focal_px(face_px));
  return (face.camera_from_face * in_face).normalized();
}

std::optional<FacePixel> face_pixel_of(const PanoramaFace& face, int face_px,
                                       const Eigen::Vector3d& camera_direction) {
  const Eigen::Vector3d in_face = face.camera_from_face.transpose() * camera_direction;
  if (in_face.z() <= 0.0) return std::nullopt;
  const double scale = focal_px(face_px) / in_face.z();
  return FacePixel{0.5 * face_px + scale * in_face.x(), 0.5 * face_px - scale * in_face.y()};
}

Eigen::Vector3d flipped(const Eigen::Vector3d& point) { return {point.x(), -point.y(), point.z()}; }

ColmapPose colmap_pose(const FramePose& camera, const PanoramaFace& face) {
  const Eigen::Matrix3d world_from_face = camera.world_from_camera * face.camera_from_face;
  const Eigen::Vector3d centre_m = camera.position_m + camera.world_from_camera * face.centre_m;
  // Flipped on both sides, the determinant stays +1: a rotation in right-handed frames.
  const Eigen::Matrix3d rotation = flip() * world_from_face.transpose() * flip();
  return {Eigen::Quaterniond(rotation).normalized(), -rotation * flipped(centre_m)};
}

FaceCutter::FaceCutter(const std::array<PanoramaFace, kFaceCount>& faces, PanoramaSize panorama,
                       int face_px)
    : faces_(faces), panorama_(panorama), reduced_(panorama), face_px_(face_px) {
  const int native = native_width(face_px);
  if (panorama.width > native) reduced_ = {native, native / 2};
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    sources_[i].reserve(static_cast<std::size_t>(face_px) * static_cast<std::size_t>(face_px));
    for (int y = 0; y < face_px; ++y) {
      for (int x = 0; x < face_px; ++x) {
        const Eigen::Vector3d direction = direction_of(faces_[i], face_px, {x + 0.5, y + 0.5});
        sources_[i].push_back(pixel_from_angles(angles_from_direction(direction), reduced_));
      }
    }
  }
}

std::array<cv::Mat, kFaceCount> FaceCutter::cut(const cv::Mat& panorama) const {
  cv::Mat reduced = panorama;
  const cv::Size size(reduced_.width, reduced_.height);
  if (panorama.size() != size) cv::resize(panorama, reduced, size, 0, 0, cv::INTER_AREA);
  const PanoramaSampler sampler(reduced);
  std::array<cv::Mat, kFaceCount> faces{};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    cv::Mat color(face_px_, face_px_, CV_8UC3);
    std::size_t at = 0;
    for (int y = 0; y < face_px_; ++y) {
      auto* row = color.ptr<cv::Vec3b>(y);
      for (int x = 0; x < face_px_; ++x) row[x] = cv::Vec3b(sampler.at(sources_[i][at++]));
    }
    cv::cvtColor(color, faces[i], cv::COLOR_BGR2GRAY);
  }
  return faces;
}

std::array<cv::Mat, kFaceCount> FaceCutter::cut_mask(const cv::Mat& mask, double seam_deg) const {
  const double seam = std::sin(radians_from_degrees(seam_deg));
  std::array<cv::Mat, kFaceCount> faces{};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces[i].create(face_px_, face_px_, CV_8UC1);
    for (int y = 0; y < face_px_; ++y) {
      for (int x = 0; x < face_px_; ++x) {
        const Eigen::Vector3d direction = direction_of(faces_[i], face_px_, {x + 0.5, y + 0.5});
        const bool usable = mask.at<uchar>(nearest_pixel(direction, mask.size())) != 0 &&
                            std::abs(direction.z()) >= seam;
        faces[i].at<uchar>(y, x) = usable ? 255 : 0;
      }
    }
  }
  return faces;
}

}  // namespace raywalk::calibrate
