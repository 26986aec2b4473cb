#include "calibrate/lens/lens_uncertainty.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

using LensCovariance = Eigen::Matrix<double, kLensParameters, kLensParameters>;

// Root mean square over the azimuths of the standard deviation of the image position at the angle
// t. With c, s the cosine and sine of the azimuth the position is (u + f m(t) c, v - f m(t) s),
// where m(t) is fisheye_radius; the derivatives are below.
double imaging_sigma_px(const LensParameters& lens, const LensCovariance& covariance, double t) {
  constexpr int kAzimuths = 16;
  double variance = 0.0;
  for (int i = 0; i < kAzimuths; ++i) {
    const double azimuth = kTwoPi * i / kAzimuths;
    Eigen::Matrix<double, 1, kLensParameters> along;  // of the radius, without the centre
    along.setZero();
    along[2] = fisheye_radius(lens.data() + 3, t);
    double power = lens[2] * t;
    for (int k = 3; k < kLensParameters; ++k) along[k] = power *= t * t;
    Eigen::Matrix<double, 2, kLensParameters> slope;
    slope.row(0) = std::cos(azimuth) * along;
    slope.row(1) = -std::sin(azimuth) * along;
    slope(0, 0) = slope(1, 1) = 1.0;
    variance += (slope * covariance * slope.transpose()).trace() / kAzimuths;
  }
  return std::sqrt(variance);
}

LensUncertainty uncertainty_of_lens(const LensParameters& lens, const LensCovariance& covariance,
                                    double largest_angle_rad) {
  const auto sigma = [&](int i) { return std::sqrt(covariance(i, i)); };
  LensUncertainty result;
  result.centre_u_px = sigma(0);
  result.centre_v_px = sigma(1);
  result.focal_px = sigma(2);
  result.k = {sigma(3), sigma(4), sigma(5), sigma(6)};
  result.middle_px = imaging_sigma_px(lens, covariance, 0.5 * largest_angle_rad);
  result.rim_px = imaging_sigma_px(lens, covariance, largest_angle_rad);
  return result;
}

}  // namespace

double CameraUncertainty::worst_px() const {
  return std::max({front.middle_px, front.rim_px, back.middle_px, back.rim_px});
}

CameraUncertainty uncertainty_of(const CameraParameters& parameters,
                                 const CameraCovariance& covariance,
                                 const DualFisheyeLayout& layout) {
  CameraUncertainty result;
  result.front = uncertainty_of_lens(parameters.front,
                                     covariance.block<kLensParameters, kLensParameters>(0, 0),
                                     layout.front.largest_angle_rad);
  result.back = uncertainty_of_lens(
      parameters.back,
      covariance.block<kLensParameters, kLensParameters>(kLensParameters, kLensParameters),
      layout.back.largest_angle_rad);
  for (int i = 0; i < 3; ++i) {
    const int rotation = 2 * kLensParameters + i;
    const int position = rotation + 3;
    result.back_rotation_deg[i] = degrees_from_radians(std::sqrt(covariance(rotation, rotation)));
    result.baseline_mm[i] = 1000.0 * std::sqrt(covariance(position, position));
  }
  return result;
}

}  // namespace raywalk::calibrate
