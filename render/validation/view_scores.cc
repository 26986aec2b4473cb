#include "render/validation/view_scores.h"

#include <algorithm>

#include "render/metrics/fsim.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace raywalk {

ViewScores score_view(const cv::Mat& view, const cv::Mat& truth) {
  return {.psnr_db = std::min(kMostPsnrDb, psnr_db(view, truth)),
          .ws_psnr_db = std::min(kMostPsnrDb, ws_psnr_db(view, truth)),
          .ssim = ssim(view, truth),
          .fsim = fsim(view, truth)};
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
