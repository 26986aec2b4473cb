#include "calibrate/lens/fit_details.h"

#include <ceres/covariance.h>
#include <ceres/ordered_groups.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "calibrate/base/stop_on_interrupt.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

double off_axis_of(const FisheyeLens& lens, PixelPosition seen) {
  const auto direction = unproject(lens, seen);
  if (!direction) return lens.largest_angle_rad;
  return std::acos(std::clamp(direction->z(), -1.0, 1.0));
}

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

void solve_fit(ceres::Problem* problem, const std::vector<double*>& eliminated_first,
               int most_iterations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = most_iterations;
  options.num_threads = thread_count();
  options.logging_type = ceres::SILENT;
  if (!eliminated_first.empty()) {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    problem->GetParameterBlocks(&blocks);
    for (double* block : blocks) ordering->AddElementToGroup(block, 1);
    for (double* block : eliminated_first) ordering->AddElementToGroup(block, 0);
    options.linear_solver_ordering = std::move(ordering);
  }
  StopOnInterrupt stop;
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  throw_if_interrupted();
  if (!summary.IsSolutionUsable()) {
    throw Error(
        "the fit of the lenses does not converge; use better starting values of the lenses");
  }
}

std::optional<CameraCovariance> camera_covariance(ceres::Problem* problem,
                                                  const CameraParameters& camera) {
  ceres::Covariance::Options options;
  options.num_threads = thread_count();
  ceres::Covariance covariance(options);
  const std::vector<const double*> blocks{camera.front.data(), camera.back.data(),
                                          camera.back_pose.data()};
  if (!covariance.Compute(blocks, problem)) return std::nullopt;
  Eigen::Matrix<double, kCameraParameters, kCameraParameters, Eigen::RowMajor> matrix;
  if (!covariance.GetCovarianceMatrix(blocks, matrix.data())) return std::nullopt;
  return matrix;
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

void set_residuals(const std::vector<FitResidual>& residuals, LensFit* fit) {
  const DualFisheyeLayout& layout = fit->camera.layout;
  double squares = 0.0;
  for (const FitResidual& residual : residuals) {
    fit->residuals.push_back(
        {residual.back, residual.seen, residual.difference_px.x(), residual.difference_px.y(),
         off_axis_of(residual.back ? layout.back : layout.front, residual.seen)});
    squares += residual.difference_px.squaredNorm();
  }
  fit->observations = static_cast<int>(residuals.size());
  fit->residual_px = std::sqrt(squares / std::max(1, fit->observations));
}

void set_uncertainty(const CameraParameters& parameters,
                     const std::optional<CameraCovariance>& covariance, LensFit* fit) {
  if (covariance) {
    fit->sigma = uncertainty_of(parameters, *covariance, fit->camera.layout);
  } else {
    fit->warnings.emplace_back("the uncertainty of the lenses is unknown: the fit is singular");
  }
}

}  // namespace raywalk::calibrate
