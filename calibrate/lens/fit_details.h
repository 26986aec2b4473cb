// Parts of the camera fit: solving, covariance and residuals.
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/camera_model.h"

namespace raywalk::calibrate {

// An observation further from the fit than this many standard deviations is an outlier.
inline constexpr double kOutlierSigmas = 5.0;

// Runs the solver until it converges. `eliminated_first` are the parameter blocks of points, for
// the Schur complement. Throws Interrupted, and Error if there is no usable solution.
void solve_fit(ceres::Problem* problem, const std::vector<double*>& eliminated_first,
               int most_iterations);

// Covariance of front, back and back_pose, which are parameters of the problem (constant ones have
// variance 0); nullopt if the problem does not determine them.
std::optional<CameraCovariance> camera_covariance(ceres::Problem* problem,
                                                  const CameraParameters& camera);

// The standard deviations that follow from it.
CameraUncertainty uncertainty_of(const CameraParameters& parameters,
                                 const CameraCovariance& covariance,
                                 const DualFisheyeLayout& layout);

// Sets residuals, their number and root mean square, and the uncertainties.
struct FitResidual {
  bool back = false;
  PixelPosition seen{};
  Eigen::Vector2d difference_px{0, 0};  // seen minus fitted; right and down
};
void set_residuals(const std::vector<FitResidual>& residuals, LensFit* fit);
void set_uncertainty(const CameraParameters& parameters,
                     const std::optional<CameraCovariance>& covariance, LensFit* fit);

}  // namespace raywalk::calibrate
