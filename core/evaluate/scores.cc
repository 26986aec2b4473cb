#include "core/evaluate/scores.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/evaluate/fsim.h"
#include "core/evaluate/metrics.h"
#include "core/geometry/panorama_pixels.h"
#include "core/view/view_plan.h"

namespace raywalk {

using nlohmann::ordered_json;

ordered_json scores_of(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  const cv::Mat completed = truth_completed_by(view, truth, mask);
  return {{"psnr_db", std::min(kMaxPsnrDb, psnr_db(view, truth, mask))},
          {"ws_psnr_db", std::min(kMaxPsnrDb, ws_psnr_db(view, truth, mask))},
          {"ssim", ssim(view, completed)},
          {"fsim", fsim(view, completed)}};
}

cv::Mat truth_completed_by(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  if (mask.empty()) return truth;
  cv::Mat completed = view.clone();
  truth.copyTo(completed, mask);
  return completed;
}

ordered_json quarter_scores_of(const Grid& grid, PlanPoint viewpoint, const cv::Mat& view,
                               const cv::Mat& truth, const cv::Mat& mask) {
  // Ray-space360's plan without a blend: straight ahead every side is read from its own line.
  const ViewPlan plan(grid, viewpoint, {kHalfPi, 0.0});
  ordered_json quarters = ordered_json::array();
  for (const Side side : {Side::kFront, Side::kRight, Side::kBack, Side::kLeft}) {
    const double theta_rad = side_normal_rad(side);
    const ColumnPlan ahead = plan.column(theta_rad);
    if (ahead.front_count == 0) continue;
    const cv::Mat counted = mask.empty() ? mask : quarter_of(mask, theta_rad);
    if (!counted.empty() && cv::countNonZero(counted) == 0) continue;
    ordered_json scores =
        scores_of(quarter_of(view, theta_rad), quarter_of(truth, theta_rad), counted);
    scores.erase("ws_psnr_db");  // of whole panoramas
    ordered_json quarter{{"line_distance_m", ahead.front[0].d_p_m}};
    quarter.update(scores);
    quarters.push_back(quarter);
  }
  return quarters;
}

cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad) {
  const int quarter = panorama.cols / 4;
  cv::Mat around;
  cv::copyMakeBorder(panorama, around, 0, 0, quarter, quarter, cv::BORDER_WRAP);
  const double centre = (theta_rad / kTwoPi + 0.5) * panorama.cols;  // the pixel edge at theta
  const int first = static_cast<int>(std::lround(centre - 0.5 * quarter));
  const int begin = quarter + wrapped_column(first, panorama.cols);
  return around.colRange(begin, begin + quarter);
}

ordered_json mean_of(std::span<const ordered_json> rows, const std::string& key) {
  double sum = 0.0;
  int known = 0;
  for (const ordered_json& row : rows) {
    const auto value = row.find(key);
    if (value == row.end() || value->is_null()) continue;
    sum += value->get<double>();
    ++known;
  }
  return known == 0 ? ordered_json(nullptr) : ordered_json(sum / known);
}

}  // namespace raywalk
