// Blends the two lenses' halves of a panorama along their seam.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "calibrate/stitch/stitch_tables.h"

namespace raywalk::calibrate {

// Levels are blended times this, which keeps fractions of a level.
inline constexpr int kLevelParts = 16;

// Works only on tiles near the seam, about a fifth of the panorama. Thread-safe.
class SeamBlend {
 public:
  // Keeps a reference to the tables' pictures (cv::Mat shares them).
  SeamBlend(const StitchTables& tables, const StitcherOptions& options);

  // `front` and `back` are CV_16SC3, levels times kLevelParts, of the tables' size, each valid
  // where StitchTables::region includes its lens. Writes the panorama to `front`.
  void blend(cv::Mat* front, const cv::Mat& back) const;

 private:
  cv::Mat multi_band(const cv::Mat& front, const cv::Mat& back, const cv::Rect& tile) const;
  void blend_bands(cv::Mat* front, const cv::Mat& back) const;
  void feather(cv::Mat* front, const cv::Mat& back) const;

  BlendMethod method_;
  cv::Mat region_;
  cv::Mat front_weight_;
  int bands_ = 1;
  int reach_px_ = 0;  // distance beyond a tile that its coarsest band reads
  std::vector<cv::Rect> tiles_{};
};

}  // namespace raywalk::calibrate
