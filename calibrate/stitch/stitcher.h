// Stitches the frames of one dual-fisheye camera to panoramas.
#pragma once

#include <opencv2/core.hpp>

#include "calibrate/stitch/lens_balance.h"
#include "calibrate/stitch/seam_blend.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/lens_file.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// The width at which a panorama has the resolution of the camera's pictures at the lens axis, 2 pi
// focal lengths, rounded to a multiple of 16.
int default_panorama_width(const DualFisheyeCamera& camera);

// Number of pixels of a stitcher's tables, before averaging down.
double table_pixels(const DualFisheyeCamera& camera, int width);

struct StitchedFrame {
  cv::Mat panorama{};  // CV_8UC3
  cv::Mat mask{};      // CV_8UC1 of its size, 0 = masked, 255 valid; empty: nothing is masked
};

// Construct once for all frames of a camera in its own axes: the tables take about a second. In
// world axes every frame needs its own, as its attitude is part of them: a pixel is then sampled
// once, from the fisheye pictures. A panorama coarser than the frames is stitched at a multiple of
// its size and averaged down to avoid aliasing. Thread-safe; each frame is stitched by one thread.
class Stitcher {
 public:
  // `width` of the panoramas is even, 64 to 32768. Throws UsageError for width and options out of
  // range, Error for lenses that leave a gap between them.
  Stitcher(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
           const LensBalance& balance,
           const Eigen::Matrix3d& world_from_camera = Eigen::Matrix3d::Identity());

  PanoramaSize size() const { return size_; }

  // The panorama, CV_8UC3, of a frame that holds both image circles, or of one picture for each
  // lens. They are CV_8UC3 and of the camera's picture size.
  cv::Mat stitch(const cv::Mat& both) const { return stitch(both, both); }
  cv::Mat stitch(const cv::Mat& front, const cv::Mat& back) const {
    return stitch(front, back, cv::Mat()).panorama;
  }
  // With the frame's mask, CV_8UC1 of the picture's size, 0 = masked, or empty: what one lens hides
  // the other shows where both are blended.
  StitchedFrame stitch(const cv::Mat& front, const cv::Mat& back, const cv::Mat& mask) const;

 private:
  // Averages down to the panorama's size.
  void reduce(cv::Mat* picture) const;
  void reduce_mask(cv::Mat* mask) const;

  PanoramaSize size_;
  int oversampling_;  // of the tables over the panorama
  StitchTables tables_;
  cv::Vec3f back_roots_;  // by colour: what corrects the back lens
  SeamBlend seam_;
};

}  // namespace raywalk::calibrate
