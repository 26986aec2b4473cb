#include "calibrate/lens/calibrate_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calibrate/base/figures.h"
#include "calibrate/lens/image_circle.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

// The accuracy that stitching needs: resampling alone costs a third of a pixel.
constexpr double kLargestSigma_px = 0.3;
constexpr double kLargestResidual_px = 1.0;
// Fewer features in the overlap do not determine the relative rotation of the lenses.
constexpr int kLeastOverlap = 12;

void require_options(const LensOptions& options) {
  constexpr int kLeastPairs = 6;
  if (options.pairs < kLeastPairs) {
    throw UsageError(fmt::format("{} stations are too few to fit lenses to; use at least {}",
                                 options.pairs, kLeastPairs));
  }
  if (!(options.ignore_below_deg >= 0.0 && options.ignore_below_deg < 90.0)) {
    throw UsageError(
        fmt::format("the ignored cone about the nadir has {:g} degrees; give 0 to below 90",
                    options.ignore_below_deg));
  }
}

LensFit fit_to_set(const CaptureSet& set, const DualFisheyeCamera& start,
                   const LensOptions& options) {
  if (set.layout == FrameLayout::kPanorama) {
    throw Error(set.source.string() +
                ": its frames are panoramas already, stitched by the camera; there are no lenses "
                "to calibrate, continue with `raywalk-calibrate poses`");
  }
  const bool two_files = !set.frames.empty() && set.frames.front().back.has_value();
  if (two_files != start.two_files) {
    throw Error(fmt::format(
        "{}: says that front and back are in {}, but the frames of {} are not; use a starting lens "
        "file for this camera",
        options.start.string(), start.two_files ? "two files" : "one file", set.source.string()));
  }
  return fit_to_capture(set, scaled_to(start, set.frame), options);
}

void add_warnings(LensFit* fit) {
  if (fit->residual_px > kLargestResidual_px) {
    fit->warnings.push_back(
        fmt::format("the residuals of {:.2f} px exceed noise: the lens model does not describe "
                    "these lenses, or "
                    "the pictures are not of this camera",
                    fit->residual_px));
  }
  if (fit->sigma.worst_px() > kLargestSigma_px) {
    fit->warnings.push_back(
        fmt::format("the image position of a direction is uncertain by {:.2f} px; use more "
                    "stations, spread over lines of both axes",
                    fit->sigma.worst_px()));
  }
  if (fit->overlap_points < kLeastOverlap) {
    fit->warnings.push_back(fmt::format(
        "only {} points were seen by both lenses, too few for their rotation relative to "
        "each other",
        fit->overlap_points));
  }
}

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

const FisheyeLens& lens_of(const DualFisheyeCamera& camera, bool back) {
  return back ? camera.layout.back : camera.layout.front;
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
    const FisheyeLens& lens = lens_of(fit.camera, residual.back);
    const auto direction = unproject(lens, residual.seen);
    const double off_axis_deg = degrees_from_radians(
        direction ? std::acos(std::clamp(direction->z(), -1.0, 1.0)) : lens.largest_angle_rad);
    ResidualRing& ring = rings[{residual.back, static_cast<int>(off_axis_deg / kWidth_deg)}];
    const Eigen::Vector2d px(residual.right_px, residual.down_px);
    const Eigen::Vector2d from_centre(residual.seen.u - lens.centre.u,
                                      residual.seen.v - lens.centre.v);
    ++ring.count;
    ring.squares += px.squaredNorm();
    ring.outwards_px += px.dot(from_centre.normalized());
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

// The residuals of a lens, or an evenly spaced subset of very many.
std::vector<LensResidual> residuals_of(const LensFit& fit, bool back) {
  std::vector<LensResidual> all;
  std::ranges::copy_if(fit.residuals, std::back_inserter(all),
                       [back](const LensResidual& residual) { return residual.back == back; });
  const std::size_t step = all.size() / kMostArrows + 1;
  std::vector<LensResidual> drawn;
  for (std::size_t i = 0; i < all.size(); i += step) drawn.push_back(all[i]);
  return drawn;
}

cv::Point drawn(double x, double y) {
  constexpr double kSteps = 1 << kPlaceBits;
  return {static_cast<int>(std::lround(kSteps * x)), static_cast<int>(std::lround(kSteps * y))};
}

ordered_json residual_figure(const LensFit& fit, bool back, const std::filesystem::path& out) {
  const FisheyeLens& lens = lens_of(fit.camera, back);
  const std::string name = back ? "back" : "front";
  const std::vector<LensResidual> residuals = residuals_of(fit, back);
  std::vector<double> sizes_px;
  sizes_px.reserve(residuals.size());
  for (const LensResidual& residual : residuals) {
    sizes_px.push_back(std::hypot(residual.right_px, residual.down_px));
  }
  const double typical_px = sizes_px.empty() ? 1.0 : std::max(1e-6, median(std::move(sizes_px)));
  const double per_px = kRadius_px / rim_radius_px(lens);
  const double enlarged = kTypicalArrow_px / typical_px;
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

ordered_json residual_figures(const LensFit& fit, const std::filesystem::path& out) {
  return ordered_json::array({residual_figure(fit, false, out), residual_figure(fit, true, out)});
}

LensFit calibrate_lens(const CaptureSet& set, const LensOptions& options) {
  require_options(options);
  const DualFisheyeCamera start = read_lens_file(options.start);
  LensFit fit = fit_to_set(set, start, options);
  add_warnings(&fit);
  require_monotonic_radius(fit.camera.layout.front);
  require_monotonic_radius(fit.camera.layout.back);
  make_directories(options.out);
  ordered_json document = lens_document(fit);
  document["figures"] = residual_figures(fit, options.out);
  write_file_atomically(options.out / "lens.json", json_text(document));
  // Last, as the next steps check for this file.
  write_lens_file(options.out / "lens.yaml", fit.camera);
  return fit;
}

}  // namespace raywalk::calibrate
