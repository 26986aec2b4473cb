// Scores of a rendered view against its ground truth: one number per metric of
// core/evaluate/metrics.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

#include "core/evaluate/metrics/psnr.h"

namespace raywalk {

struct ViewScores {
  double psnr_db = 0.0;     // over RGB, at most kMaxPsnrDb
  double ws_psnr_db = 0.0;  // the same weighted by solid angle
  double ssim = 0.0;        // on luma
  double fsim = 0.0;        // on luma
};

// Pixels where `mask` (CV_8UC1 of the pictures' size, or empty) is 0 are ignored: the PSNRs skip
// them; for SSIM and FSIM, which compare neighbourhoods, the truth there is replaced by the view.
// Throws Error as the metrics do (sizes differ, not CV_8UC3, nothing but masked pixels).
ViewScores score_view(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask = cv::Mat());

// The truth, with the view's own pixels where `mask` is 0. Without a mask the truth itself.
cv::Mat truth_completed_by(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask);

// Mean of each member. `scores` is not empty.
ViewScores mean_of(std::span<const ViewScores> scores);

}  // namespace raywalk
