#include "calibrate/lens/lens_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "calibrate/base/figures.h"
#include "calibrate/lens/image_circle.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

// A parameter of the camera before and after the fit; a sigma of 0: not fitted.
ordered_json value_json(double start, double fitted, double sigma) {
  ordered_json value{{"start", start}, {"fitted", fitted}, {"sigma", nullptr}};
  if (sigma > 0.0) value["sigma"] = sigma;
  return value;
}

ordered_json angle_json(double start_rad, double fitted_rad, double sigma_deg) {
  return value_json(degrees_from_radians(start_rad), degrees_from_radians(fitted_rad), sigma_deg);
}

// The keys are those of the lens file.
ordered_json lens_json(const FisheyeLens& start, const FisheyeLens& fitted,
                       const LensUncertainty& sigma) {
  ordered_json lens{{"centre_u_px", value_json(start.centre.u, fitted.centre.u, sigma.centre_u_px)},
                    {"centre_v_px", value_json(start.centre.v, fitted.centre.v, sigma.centre_v_px)},
                    {"focal_px", value_json(start.focal_px, fitted.focal_px, sigma.focal_px)}};
  for (std::size_t i = 0; i < fitted.k.size(); ++i) {
    lens["k" + std::to_string(i + 1)] = value_json(start.k[i], fitted.k[i], sigma.k[i]);
  }
  lens["largest_angle_deg"] = angle_json(start.largest_angle_rad, fitted.largest_angle_rad, 0.0);
  lens["imaging_sigma_px"] = {{"middle", sigma.middle_px}, {"rim", sigma.rim_px}};
  return lens;
}

ordered_json back_json(const LensFit& fit) {
  ordered_json lens = lens_json(fit.start.layout.back, fit.camera.layout.back, fit.sigma.back);
  const Attitude& start = fit.start.layout.back_attitude;
  const Attitude& fitted = fit.camera.layout.back_attitude;
  // Of the equivalent values of a yaw, the one nearest to the start's.
  const double yaw_rad = start.yaw_rad + wrap_angle(fitted.yaw_rad - start.yaw_rad);
  // A rotation about the lens's y is a yaw, about x a pitch and about z a roll, as it is upright.
  const Eigen::Vector3d& sigma = fit.sigma.back_rotation_deg;
  lens["yaw_deg"] = angle_json(start.yaw_rad, yaw_rad, sigma.y());
  lens["pitch_deg"] = angle_json(start.pitch_rad, fitted.pitch_rad, sigma.x());
  lens["roll_deg"] = angle_json(start.roll_rad, fitted.roll_rad, sigma.z());
  return lens;
}

ordered_json baseline_json(const LensFit& fit) {
  const auto baseline_mm = [](const DualFisheyeLayout& layout) -> Eigen::Vector3d {
    return 1000.0 * (layout.back_position_m - layout.front_position_m);
  };
  const Eigen::Vector3d start = baseline_mm(fit.start.layout);
  const Eigen::Vector3d fitted = baseline_mm(fit.camera.layout);
  const Eigen::Vector3d& sigma = fit.sigma.baseline_mm;
  return {{"x", value_json(start.x(), fitted.x(), sigma.x())},
          {"y", value_json(start.y(), fitted.y(), sigma.y())},
          {"z", value_json(start.z(), fitted.z(), sigma.z())}};
}

// Sums over the residuals in a ring around a lens's axis.
struct ResidualRing {
  int count = 0;
  double squares = 0.0;
  double outwards_px = 0.0;  // shows an error of the radial model
};

// Rings of five degrees with at least one residual, by lens and angle.
ordered_json rings_json(const LensFit& fit) {
  constexpr double kWidth_deg = 5.0;
  std::map<std::pair<bool, int>, ResidualRing> rings;
  for (const LensResidual& residual : fit.residuals) {
    const double off_axis_deg = degrees_from_radians(residual.off_axis_rad);
    ResidualRing& ring = rings[{residual.back, static_cast<int>(off_axis_deg / kWidth_deg)}];
    ++ring.count;
    ring.squares += residual.right_px * residual.right_px + residual.down_px * residual.down_px;
    const FisheyeLens& lens = residual.back ? fit.camera.layout.back : fit.camera.layout.front;
    const double right = residual.seen.u - lens.centre.u, down = residual.seen.v - lens.centre.v;
    const double radius = std::hypot(right, down);
    if (radius > 0.0) {
      ring.outwards_px += (right * residual.right_px + down * residual.down_px) / radius;
    }
  }
  ordered_json json = ordered_json::array();
  for (const auto& [place, ring] : rings) {
    json.push_back({{"lens", place.first ? "back" : "front"},
                    {"off_axis_deg", (place.second + 0.5) * kWidth_deg},
                    {"count", ring.count},
                    {"rms_px", std::sqrt(ring.squares / ring.count)},
                    {"radial_px", ring.outwards_px / ring.count}});
  }
  return json;
}

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

ordered_json lens_document(const LensFit& fit) {
  return {{"format", "raywalk-lens"},
          {"format_version", 1},
          {"trustworthy", fit.trustworthy()},
          {"warnings", fit.warnings},
          {"residual_px", fit.residual_px},
          {"worst_imaging_sigma_px", fit.sigma.worst_px()},
          {"pictures", fit.pictures},
          {"points", fit.points},
          {"overlap_points", fit.overlap_points},
          {"observations", fit.observations},
          {"dropped_observations", fit.dropped_observations},
          {"dropped_still", fit.dropped_still},
          {"picture",
           {{"width_px", fit.camera.picture.width},
            {"height_px", fit.camera.picture.height},
            {"two_files", fit.camera.two_files}}},
          {"front", lens_json(fit.start.layout.front, fit.camera.layout.front, fit.sigma.front)},
          {"back", back_json(fit)},
          {"baseline_mm", baseline_json(fit)},
          {"residuals_over_angle", rings_json(fit)}};
}

nlohmann::ordered_json residual_figures(const LensFit& fit, const std::filesystem::path& out) {
  return nlohmann::ordered_json::array(
      {residual_figure(fit, false, out), residual_figure(fit, true, out)});
}

}  // namespace raywalk::calibrate
