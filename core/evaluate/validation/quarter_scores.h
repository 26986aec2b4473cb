// Scores of the quarters of a view that face each of the lines around it: Fig. 13 of the paper
// plots them over the distance from the line.
// A view between four lines is near one and far from another, so its score as a whole does not
// belong to one distance. The quarter of the panorama that faces a side is rendered from that
// side's line (up to the corners), at one distance straight ahead: one view gives up to four
// points.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

struct QuarterScore {
  double line_distance_m = 0.0;  // from the viewpoint straight ahead to the line
  double psnr_db = 0.0;          // over RGB, at most kMaxPsnrDb
  double ssim = 0.0;             // on luma
  // On luma. FSIM assumes that columns wrap around, which is not true of a quarter: the jump
  // between its outermost columns counts as a feature, in both pictures alike.
  double fsim = 0.0;
};

// The 90 degrees around longitude `theta_rad` of a panorama whose width is a multiple of 4.
cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad);

// One score for every side that a line serves and that is not masked completely. The pictures are
// panoramas of one size, at least 32 pixels wide; `mask` is as in score_view().
std::vector<QuarterScore> score_quarters(const Grid& grid, PlanPoint viewpoint, const cv::Mat& view,
                                         const cv::Mat& truth, const cv::Mat& mask = cv::Mat());

}  // namespace raywalk
