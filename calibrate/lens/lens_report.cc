#include "calibrate/lens/lens_report.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

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

}  // namespace

ordered_json lens_document(const LensFit& fit) {
  return {{"format", "raywalk-lens"},
          {"format_version", 1},
          {"method", fit.method},
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
          {"back_pose_fitted", fit.back_pose_fitted},
          {"picture",
           {{"width_px", fit.camera.picture.width},
            {"height_px", fit.camera.picture.height},
            {"two_files", fit.camera.two_files}}},
          {"front", lens_json(fit.start.layout.front, fit.camera.layout.front, fit.sigma.front)},
          {"back", back_json(fit)},
          {"baseline_mm", baseline_json(fit)},
          {"residuals_over_angle", rings_json(fit)}};
}

}  // namespace raywalk::calibrate
