// Scores of rendered views against their truth, as rows of the reports' JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

#include "core/geometry/grid.h"

namespace raywalk {

// {"psnr_db": over RGB, "ws_psnr_db": the same weighted by solid angle, "ssim", "fsim": on luma};
// PSNRs are at most kMaxPsnrDb. Pixels where `mask` (CV_8UC1 of the images' size, or empty) is 0
// are ignored: the PSNRs skip them; for SSIM and FSIM, which compare neighbourhoods, the truth
// there is replaced by the view. Throws Error as the metrics do (sizes differ, not CV_8UC3, nothing
// but masked pixels).
nlohmann::ordered_json scores_of(const cv::Mat& view, const cv::Mat& truth,
                                 const cv::Mat& mask = cv::Mat());

// The truth, with the view's own pixels where `mask` is 0. Without a mask the truth itself.
cv::Mat truth_completed_by(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask);

// Scores of the quarters of a view that face each of the lines around it: Fig. 13 of the paper
// plots them over the distance from the line. A view between four lines is near one and far from
// another, so its score as a whole does not belong to one distance. The quarter of the panorama
// that faces a side is rendered from that side's line (up to the corners), at one distance straight
// ahead: one view gives up to four points.
//
// A list of {"line_distance_m": from the viewpoint straight ahead to the line, "psnr_db", "ssim",
// "fsim"}, one for every side that a line serves and that is not masked completely. FSIM assumes
// that columns wrap around, which is not true of a quarter: the jump between its outermost columns
// counts as a feature, in both images alike. The images are panoramas of one size, at least 32
// pixels wide.
nlohmann::ordered_json quarter_scores_of(const Grid& grid, PlanPoint viewpoint, const cv::Mat& view,
                                         const cv::Mat& truth, const cv::Mat& mask = cv::Mat());

// The 90 degrees around longitude `theta_rad` of a panorama whose width is a multiple of 4.
cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad);

// Mean of a key over the rows where it is known; null where it is in none.
nlohmann::ordered_json mean_of(std::span<const nlohmann::ordered_json> rows,
                               const std::string& key);

}  // namespace raywalk
