#include "core/evaluate/validation/view_scores.h"

#include <algorithm>

#include "core/evaluate/metrics/fsim.h"
#include "core/evaluate/metrics/psnr.h"
#include "core/evaluate/metrics/ssim.h"

namespace raywalk {

ViewScores score_view(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  const cv::Mat completed = truth_completed_by(view, truth, mask);
  return {.psnr_db = std::min(kMaxPsnrDb, psnr_db(view, truth, mask)),
          .ws_psnr_db = std::min(kMaxPsnrDb, ws_psnr_db(view, truth, mask)),
          .ssim = ssim(view, completed),
          .fsim = fsim(view, completed)};
}

cv::Mat truth_completed_by(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  if (mask.empty()) return truth;
  cv::Mat completed = view.clone();
  truth.copyTo(completed, mask);
  return completed;
}

ViewScores mean_of(std::span<const ViewScores> scores) {
  ViewScores mean;
  const double share = 1.0 / static_cast<double>(scores.size());
  for (const ViewScores& score : scores) {
    mean.psnr_db += share * score.psnr_db;
    mean.ws_psnr_db += share * score.ws_psnr_db;
    mean.ssim += share * score.ssim;
    mean.fsim += share * score.fsim;
  }
  return mean;
}

}  // namespace raywalk
