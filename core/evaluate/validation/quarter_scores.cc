#include "core/evaluate/validation/quarter_scores.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "core/evaluate/validation/view_scores.h"
#include "core/geometry/panorama_pixels.h"
#include "core/view/view_plan.h"

namespace raywalk {

cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad) {
  const int width = panorama.cols;
  const double centre = (theta_rad / kTwoPi + 0.5) * width;  // the pixel edge at theta
  const int first = static_cast<int>(std::lround(centre - width / 8.0));
  const int begin = wrapped_column(first, width);
  const int before_seam = std::min(width / 4, width - begin);
  cv::Mat left = panorama.colRange(begin, begin + before_seam);
  if (before_seam == width / 4) return left;
  cv::Mat joined;
  cv::hconcat(left, panorama.colRange(0, width / 4 - before_seam), joined);
  return joined;
}

std::vector<QuarterScore> score_quarters(const Grid& grid, PlanPoint viewpoint, const cv::Mat& view,
                                         const cv::Mat& truth, const cv::Mat& mask) {
  // Ray-space360's plan without a blend: straight ahead every side is read from its own line.
  const ViewPlan plan(grid, viewpoint, {kHalfPi, 0.0});
  std::vector<QuarterScore> scores;
  for (const Side side : {Side::kFront, Side::kRight, Side::kBack, Side::kLeft}) {
    const double theta_rad = side_normal_rad(side);
    const ColumnPlan ahead = plan.column(theta_rad);
    if (ahead.front_count == 0) continue;
    const cv::Mat seen = quarter_of(view, theta_rad);
    const cv::Mat wanted = quarter_of(truth, theta_rad);
    const cv::Mat counted = mask.empty() ? mask : quarter_of(mask, theta_rad);
    if (!counted.empty() && cv::countNonZero(counted) == 0) continue;
    const ViewScores whole = score_view(seen, wanted, counted);
    scores.push_back({.line_distance_m = ahead.front[0].d_p_m,
                      .psnr_db = whole.psnr_db,
                      .ssim = whole.ssim,
                      .fsim = whole.fsim});
  }
  return scores;
}

}  // namespace raywalk
