// A panorama reduced for comparing its light with that of others: sampled in world directions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Square grids of samples around a direction, a pixel apart, as seen from one station.
inline constexpr int kPatchRadius_px = 4;
inline constexpr int kPatchSide_px = 2 * kPatchRadius_px + 1;
inline constexpr int kPatchSamples = kPatchSide_px * kPatchSide_px;

class ComparedPanorama {
 public:
  // Empty; only to be assigned to.
  ComparedPanorama() = default;
  // `panorama` is CV_8UC3; `mask` is CV_8UC1 of its size, 0 = masked, or empty. `own_mask`: it is,
  // at least in part, of this frame alone and may hide anything, so that no patch may touch it.
  ComparedPanorama(const cv::Mat& panorama, const cv::Mat& mask, bool own_mask,
                   const FramePose& pose);

  const Eigen::Vector3d& position_m() const { return position_m_; }
  // The angle between neighbouring pixels at the horizon.
  double pixel_rad() const;
  // Unit vectors in world axes: the point of most contrast in every part of the sphere, all parts
  // of about the same solid angle.
  const std::vector<Eigen::Vector3d>& textured() const { return textured_; }

  // Mean level of the colours, 0 to 255, in a direction (world axes, any length).
  float grey(const Eigen::Vector3d& direction) const;
  // Linear light, red, green and blue, 0 to 1. Returns false where a pixel is masked, nearly black
  // or nearly clipped.
  bool light(const Eigen::Vector3d& direction, Eigen::Array3d* rgb) const;
  // Whether a patch with a sample in this direction would touch what the frame's own mask hides.
  bool hidden(const Eigen::Vector3d& direction) const;
  // The direction in the camera's axes.
  Eigen::Vector3d seen_by_camera(const Eigen::Vector3d& direction) const {
    return camera_from_world_ * direction;
  }

 private:
  // The four pixels around a direction and their weights.
  struct Place {
    int row = 0, col = 0;
    float right = 0.0F, below = 0.0F;
  };
  Place place_of(const Eigen::Vector3d& direction) const;
  void find_texture();

  Eigen::Vector3d position_m_{0, 0, 0};
  Eigen::Matrix3d camera_from_world_ = Eigen::Matrix3d::Identity();
  cv::Mat levels_;  // with a border of one pixel: CV_8UC3
  cv::Mat grey_;    // CV_8UC1
  cv::Mat usable_;  // CV_8UC1, 0: masked, black or clipped
  cv::Mat hidden_;  // CV_8UC1, 255: masked by the frame's own mask; empty if it has none
  int width_ = 0;
  std::vector<Eigen::Vector3d> textured_{};
};

}  // namespace raywalk::calibrate
