// How clean a view is at silhouettes, where near things end before far ones: there views on
// distances that are not exact tear, and leave specks.
#pragma once

#include <limits>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// NaN: not measured.
struct SilhouetteScores {
  // Of the pixels within 2 of a true silhouette, and of the others: at most kMaxPsnrDb; NaN where
  // there are none.
  double near_psnr_db = std::numeric_limits<double>::quiet_NaN();
  double elsewhere_psnr_db = std::numeric_limits<double>::quiet_NaN();
  double near_share = std::numeric_limits<double>::quiet_NaN();  // of the pixels
  double specks_per_mpx = std::numeric_limits<double>::quiet_NaN();
};

// 255 within 2 pixels (5 x 5) of a silhouette, else 0. A silhouette is between two pixels, side by
// side or one above the other, whose distances have a ratio above 1.15; both are on it. Columns
// wrap around. `distances_mm` is a true distance map, CV_16UC1 in millimetres; 0, no surface,
// counts as 65535, the farthest. Throws Error for another type.
cv::Mat near_silhouettes(const cv::Mat& distances_mm);

// Of a panorama against its truth, CV_8UC3 of the size of `distances_mm`. A speck is a pixel of the
// view that differs by over 32 levels from the median of the 3 x 3 pixels around it and by over 48
// from the truth, each in some channel, where the truth differs by less than 16 from its own median
// in every channel. Pixels where `mask` (CV_8UC1, or empty) is 0 do not count. Throws Error where
// type or size is another, or the mask leaves no pixel.
SilhouetteScores score_silhouettes(const cv::Mat& view, const cv::Mat& truth,
                                   const cv::Mat& distances_mm, const cv::Mat& mask = cv::Mat());

}  // namespace raywalk
