// Turns the frames of one dual-fisheye camera into panoramas.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/stitch/lens_balance.h"
#include "calibrate/stitch/seam_blend.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/lens_file.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// The width at which a panorama's pixels are as large as those in the middle of the camera's
// pictures, 2 pi focal lengths, rounded to a multiple of 16.
int default_panorama_width(const DualFisheyeCamera& camera);

// Built once for all frames of a camera: its tables take a second or so. A panorama coarser than
// the frames is stitched at a multiple of its size and averaged down, so that it has no jagged
// edges. Safe to use from several threads at once; one frame keeps one thread busy.
class Stitcher {
 public:
  // `width` of the panoramas is even, 64 to 32768. Throws UsageError for width and options out of
  // range, Error for lenses that leave a gap between them.
  Stitcher(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
           const LensBalance& balance);

  PanoramaSize size() const { return size_; }
  // Of the picture that is worked on.
  double table_pixels() const {
    return static_cast<double>(tables_.size.width) * tables_.size.height;
  }

  // The panorama, CV_8UC3, of a frame that holds both image circles, or of one picture for each
  // lens. They are CV_8UC3 and of the camera's picture size.
  cv::Mat stitch(const cv::Mat& both) const { return stitch(both, both); }
  cv::Mat stitch(const cv::Mat& front, const cv::Mat& back) const;

 private:
  PanoramaSize size_;
  int oversampling_;  // of the tables over the panorama
  StitchTables tables_;
  ColourRoots back_roots_;
  SeamBlend seam_;
};

}  // namespace raywalk::calibrate
