#include "core/reconstruction/panorama_faces.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/panorama/panorama_sampler.h"

namespace raywalk {
namespace {

// The width of a panorama as fine as a face in its middle: W / 2 pi = face_px / 2.
int native_width(int face_px) { return static_cast<int>(std::ceil(kPi * face_px / 2.0)) * 2; }

}  // namespace

std::vector<PanoramaFace> cube_faces() {
  std::vector<PanoramaFace> faces;
  faces.reserve(kCubeFaces.size());
  for (const CubeFace& face : kCubeFaces) faces.push_back({world_from_camera(face.attitude)});
  return faces;
}

int native_face_px(int panorama_width) {
  return std::max(2, 2 * static_cast<int>(std::lround(panorama_width / kTwoPi)));
}

Eigen::Vector3d direction_of(const PanoramaFace& face, int face_px, FacePixel pixel) {
  const double middle = 0.5 * face_px;
  const Eigen::Vector3d in_face(pixel.x - middle, middle - pixel.y, face_focal_px(face_px));
  return (face.camera_from_face * in_face).normalized();
}

std::optional<FacePixel> face_pixel_of(const PanoramaFace& face, int face_px,
                                       const Eigen::Vector3d& camera_direction) {
  const Eigen::Vector3d in_face = face.camera_from_face.transpose() * camera_direction;
  if (in_face.z() <= 0.0) return std::nullopt;
  const double scale = face_focal_px(face_px) / in_face.z();
  return FacePixel{0.5 * face_px + scale * in_face.x(), 0.5 * face_px - scale * in_face.y()};
}

FaceCutter::FaceCutter(std::span<const PanoramaFace> faces, PanoramaSize panorama, int face_px)
    : faces_(faces.begin(), faces.end()),
      reduced_(panorama),
      face_px_(face_px),
      sources_(faces.size()) {
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

std::vector<cv::Mat> FaceCutter::cut(const cv::Mat& panorama) const {
  cv::Mat reduced = panorama;
  const cv::Size size(reduced_.width, reduced_.height);
  if (panorama.size() != size) cv::resize(panorama, reduced, size, 0, 0, cv::INTER_AREA);
  const PanoramaSampler sampler(reduced);
  std::vector<cv::Mat> faces;
  for (const std::vector<PixelPosition>& sources : sources_) {
    cv::Mat color(face_px_, face_px_, CV_8UC3);
    std::size_t at = 0;
    for (int y = 0; y < face_px_; ++y) {
      auto* row = color.ptr<cv::Vec3b>(y);
      for (int x = 0; x < face_px_; ++x) row[x] = cv::Vec3b(sampler.at(sources[at++]));
    }
    faces.push_back(std::move(color));
  }
  return faces;
}

std::vector<cv::Mat> FaceCutter::cut_mask(const cv::Mat& mask, double seam_deg) const {
  const double seam = std::sin(radians_from_degrees(seam_deg));
  std::vector<cv::Mat> faces;
  for (const PanoramaFace& face : faces_) {
    cv::Mat cut(face_px_, face_px_, CV_8UC1);
    for (int y = 0; y < face_px_; ++y) {
      for (int x = 0; x < face_px_; ++x) {
        const Eigen::Vector3d direction = direction_of(face, face_px_, {x + 0.5, y + 0.5});
        const bool usable = mask.at<uchar>(nearest_pixel(direction, mask.size())) != 0 &&
                            std::abs(direction.z()) >= seam;
        cut.at<uchar>(y, x) = usable ? 255 : 0;
      }
    }
    faces.push_back(std::move(cut));
  }
  return faces;
}

}  // namespace raywalk
