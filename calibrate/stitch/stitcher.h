// Stitches the frames of one dual-fisheye camera to panoramas.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>

#include "calibrate/stitch/lens_gain.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/lens_file.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// The width at which a panorama has the resolution of the camera's pictures at the lens axis, 2 pi
// focal lengths, rounded to a multiple of 16.
int default_panorama_width(const DualFisheyeCamera& camera);

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
  // `width` of the panoramas is even, 64 to 32768; gains are above 0. Throws UsageError for width
  // and options out of range, Error for lenses that leave a gap between them.
  Stitcher(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
           const ColourGains& back_gain = kEqualLenses,
           const Eigen::Matrix3d& world_from_camera = Eigen::Matrix3d::Identity());

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

  PanoramaSize size_;
  StitcherOptions options_;
  StitchTables tables_;
  cv::Vec3f back_roots_;  // by colour: what corrects the back lens
};

// How many frames can be stitched at once in the memory that is meant for it; at least 1 and at
// most thread_count(). `own_tables`: each by a stitcher of its own.
int frames_at_once(const DualFisheyeCamera& camera, int width, bool own_tables);

// Calls work(0) to work(count - 1) on that many threads, each taking the next frame. The first
// exception, or Interrupted, ends it after the frames that have begun.
void for_each_frame(std::size_t count, int at_once, const std::function<void(std::size_t)>& work);

}  // namespace raywalk::calibrate
