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

}  // namespace

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
