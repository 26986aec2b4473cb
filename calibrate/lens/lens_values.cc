#include "calibrate/lens/lens_values.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace raywalk::calibrate {
namespace {

std::vector<LensValue> values_of(const FisheyeLens& start, const FisheyeLens& fitted,
                                 const LensUncertainty& sigma) {
  std::vector<LensValue> values{{"centre_u_px", start.centre.u, fitted.centre.u, sigma.centre_u_px},
                                {"centre_v_px", start.centre.v, fitted.centre.v, sigma.centre_v_px},
                                {"focal_px", start.focal_px, fitted.focal_px, sigma.focal_px}};
  for (std::size_t i = 0; i < fitted.k.size(); ++i) {
    const std::string key = "k" + std::to_string(i + 1);
    values.push_back({key, start.k[i], fitted.k[i], sigma.k[i]});
  }
  values.push_back({"largest_angle_deg", degrees_from_radians(start.largest_angle_rad),
                    degrees_from_radians(fitted.largest_angle_rad), 0.0});
  return values;
}

}  // namespace

std::vector<LensValue> front_values(const LensFit& fit) {
  return values_of(fit.start.layout.front, fit.camera.layout.front, fit.sigma.front);
}

std::vector<LensValue> back_values(const LensFit& fit) {
  std::vector<LensValue> values =
      values_of(fit.start.layout.back, fit.camera.layout.back, fit.sigma.back);
  const Attitude& start = fit.start.layout.back_attitude;
  const Attitude& fitted = fit.camera.layout.back_attitude;
  // Of the equivalent values of a yaw, the one nearest to the start's.
  const double yaw_rad = start.yaw_rad + wrap_angle(fitted.yaw_rad - start.yaw_rad);
  // A rotation about the lens's y is a yaw, about x a pitch and about z a roll, as it is upright.
  const Eigen::Vector3d& sigma = fit.sigma.back_rotation_deg;
  values.push_back(
      {"yaw_deg", degrees_from_radians(start.yaw_rad), degrees_from_radians(yaw_rad), sigma.y()});
  values.push_back({"pitch_deg", degrees_from_radians(start.pitch_rad),
                    degrees_from_radians(fitted.pitch_rad), sigma.x()});
  values.push_back({"roll_deg", degrees_from_radians(start.roll_rad),
                    degrees_from_radians(fitted.roll_rad), sigma.z()});
  return values;
}

std::vector<LensValue> baseline_values(const LensFit& fit) {
  const auto baseline_mm = [](const DualFisheyeLayout& layout) -> Eigen::Vector3d {
    return 1000.0 * (layout.back_position_m - layout.front_position_m);
  };
  const Eigen::Vector3d start = baseline_mm(fit.start.layout);
  const Eigen::Vector3d fitted = baseline_mm(fit.camera.layout);
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  std::vector<LensValue> values;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    values.push_back({kAxes[at], start[i], fitted[i], fit.sigma.baseline_mm[i]});
  }
  return values;
}

std::vector<ResidualRing> residual_rings(const LensFit& fit) {
  constexpr double kWidth_rad = radians_from_degrees(5.0);
  std::map<std::pair<bool, int>, ResidualRing> rings;
  for (const LensResidual& residual : fit.residuals) {
    const int number = static_cast<int>(residual.off_axis_rad / kWidth_rad);
    ResidualRing& ring = rings[{residual.back, number}];
    ring.back = residual.back;
    ring.off_axis_rad = (number + 0.5) * kWidth_rad;
    ++ring.count;
    ring.rms_px += residual.right_px * residual.right_px + residual.down_px * residual.down_px;
    const FisheyeLens& lens = residual.back ? fit.camera.layout.back : fit.camera.layout.front;
    const double right = residual.seen.u - lens.centre.u, down = residual.seen.v - lens.centre.v;
    const double radius = std::hypot(right, down);
    if (radius > 0.0) {
      ring.radial_px += (right * residual.right_px + down * residual.down_px) / radius;
    }
  }
  std::vector<ResidualRing> result;
  for (auto& [key, ring] : rings) {
    ring.rms_px = std::sqrt(ring.rms_px / ring.count);
    ring.radial_px /= ring.count;
    result.push_back(ring);
  }
  return result;
}

}  // namespace raywalk::calibrate
