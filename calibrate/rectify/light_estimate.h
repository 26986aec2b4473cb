// The exposures of a set of pictures by the light of the surfaces that pairs of them share.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace raywalk::calibrate {

// Darkening that depends on the place in the picture, as by vignetting, is the same function in all
// pictures: the real spherical harmonics of degree 1 and 2 of the direction in the camera's axes.
inline constexpr int kLensTerms = 8;
using LensTerms = Eigen::Matrix<double, kLensTerms, 1>;
// `seen` is a unit vector in the camera's axes.
LensTerms lens_terms(const Eigen::Vector3d& seen);

inline constexpr int kSceneParts = 24;

// The light of one surface in two pictures.
struct LightSample {
  int from = 0, to = 0;                // pictures
  double log_ratio = 0.0;              // ln (light in `to` / light in `from`)
  double error = 1.0;                  // above 0; only ratios of errors matter
  int part = 0;                        // of the scene, 0 to kSceneParts - 1
  LensTerms lens = LensTerms::Zero();  // of `to` less those of `from`
};

struct LightEstimate {
  // By picture: ln of the exposure, relative to the mean over the pictures it is linked with; 0
  // for pictures without samples.
  Eigen::VectorXd log_light;
  // [part of the scene][picture]: how much the samples of that part move log_light away from what
  // all samples together give. Errors of one surface are the same wherever it is seen, so parts of
  // the scene are independent and single samples are not: the covariance is influence^T influence
  // (cluster-robust; Liang and Zeger, Biometrika 73, 1986).
  // Rows of parts without samples are 0.
  Eigen::MatrixXd influence;
  LensTerms lens = LensTerms::Zero();  // coefficients
};

// Robust weighted least squares (Tukey's biweight, by iterative reweighting) of
//   log_ratio = log_light(to) - log_light(from) + lens . coefficients.
// Needs samples of at least two parts of the scene, else everything is 0.
LightEstimate estimate_light(std::span<const LightSample> samples, int pictures);

}  // namespace raywalk::calibrate
