#include "calibrate/lens/residual_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibrate/base/figures.h"
#include "calibrate/lens/image_circle.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr int kSide_px = 720;
constexpr double kRadius_px = 0.48 * kSide_px;  // of the image circle as drawn
constexpr std::size_t kMostArrows = 2500;
// Drawn length of the median residual.
constexpr double kTypicalArrow_px = 12.0;
constexpr int kPlaceBits = 4;  // of a drawn place, after the point

// BGR.
const cv::Scalar kPaper(255, 255, 255);
const cv::Scalar kRim(175, 163, 152);
const cv::Scalar kInk(51, 41, 31);
const cv::Scalar kArrow(0, 94, 213);

std::vector<LensResidual> residuals_of(const LensFit& fit, bool back) {
  std::vector<LensResidual> all;
  std::ranges::copy_if(fit.residuals, std::back_inserter(all),
                       [back](const LensResidual& residual) { return residual.back == back; });
  const std::size_t step = std::max<std::size_t>((all.size() + kMostArrows - 1) / kMostArrows, 1);
  std::vector<LensResidual> drawn;
  for (std::size_t i = 0; i < all.size(); i += step) drawn.push_back(all[i]);
  return drawn;
}

double median_size_px(const std::vector<LensResidual>& residuals) {
  if (residuals.empty()) return 1.0;
  std::vector<double> sizes;
  sizes.reserve(residuals.size());
  for (const LensResidual& residual : residuals) {
    sizes.push_back(std::hypot(residual.right_px, residual.down_px));
  }
  return std::max(1e-6, median(std::move(sizes)));
}

cv::Point drawn(double x, double y) {
  constexpr double kSteps = 1 << kPlaceBits;
  return {static_cast<int>(std::lround(kSteps * x)), static_cast<int>(std::lround(kSteps * y))};
}

nlohmann::ordered_json residual_figure(const LensFit& fit, bool back,
                                       const std::filesystem::path& out) {
  const FisheyeLens& lens = back ? fit.camera.layout.back : fit.camera.layout.front;
  const std::string name = back ? "back" : "front";
  const std::vector<LensResidual> residuals = residuals_of(fit, back);
  const double per_px = kRadius_px / rim_radius_px(lens);
  const double enlarged = kTypicalArrow_px / median_size_px(residuals);
  constexpr double kMiddle_px = 0.5 * kSide_px;
  cv::Mat image(kSide_px, kSide_px, CV_8UC3, kPaper);
  cv::circle(image, cv::Point(kSide_px / 2, kSide_px / 2), static_cast<int>(kRadius_px), kRim, 1,
             cv::LINE_AA);
  // Arrows start at the fitted point, marked by a dot, and end at the observed one.
  for (const LensResidual& residual : residuals) {
    const double x = kMiddle_px + (residual.seen.u - lens.centre.u) * per_px;
    const double y = kMiddle_px + (residual.seen.v - lens.centre.v) * per_px;
    const cv::Point from = drawn(x, y);
    const cv::Point to = drawn(x + residual.right_px * enlarged, y + residual.down_px * enlarged);
    cv::line(image, from, to, kArrow, 1, cv::LINE_AA, kPlaceBits);
    cv::circle(image, from, 1 << kPlaceBits, kInk, cv::FILLED, cv::LINE_AA, kPlaceBits);
  }
  const std::string caption =
      fmt::format("{} lens: {} image points, residuals enlarged {:.0f} times", name,
                  residuals.size(), enlarged / per_px);
  return write_figure(out, "lens_" + name, "Residuals", caption, image);
}

}  // namespace

nlohmann::ordered_json residual_figures(const LensFit& fit, const std::filesystem::path& out) {
  return nlohmann::ordered_json::array(
      {residual_figure(fit, false, out), residual_figure(fit, true, out)});
}

}  // namespace raywalk::calibrate
