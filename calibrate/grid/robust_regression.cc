#include "calibrate/grid/robust_regression.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// The rows of a matrix to keep.
Eigen::MatrixXd rows_of(const Eigen::MatrixXd& matrix, const std::vector<bool>& use) {
  Eigen::MatrixXd result(std::count(use.begin(), use.end(), true), matrix.cols());
  Eigen::Index to = 0;
  for (size_t i = 0; i < use.size(); ++i) {
    if (use[i]) result.row(to++) = matrix.row(static_cast<Eigen::Index>(i));
  }
  return result;
}

// Tukey's biweight: zero weight beyond 4.685 standard deviations (95 % efficiency under normal
// errors).
double biweight(double sigmas) {
  constexpr double kEnd = 4.685;
  if (sigmas >= kEnd) return 0.0;
  const double rest = 1.0 - (sigmas / kEnd) * (sigmas / kEnd);
  return rest * rest;
}

// Iteratively reweighted least squares: `weight` maps a sample's previous weight and its residual
// in robust standard deviations to its new weight.
template <typename Weight>
Eigen::VectorXd reweighted(const Eigen::MatrixXd& basis, const Eigen::VectorXd& data, double least,
                           Eigen::VectorXd weights, const Weight& weight) {
  constexpr int kRounds = 30;
  Eigen::VectorXd solution;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd roots = weights.cwiseSqrt();
    solution = least_squares(roots.asDiagonal() * basis, roots.cwiseProduct(data));
    const Eigen::VectorXd residuals = data - basis * solution;
    const double sigma = residual_sigma(residuals, least);
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      weights[i] = weight(weights[i], std::fabs(residuals[i]) / sigma);
    }
  }
  return solution;
}

}  // namespace

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data) {
  return basis.colPivHouseholderQr().solve(data);
}

double residual_sigma(const Eigen::VectorXd& residuals, double least) {
  std::vector<double> sizes(static_cast<size_t>(residuals.size()));
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    sizes[static_cast<size_t>(i)] = std::fabs(residuals[i]);
  }
  return std::max(least, robust_sigma(std::move(sizes)));
}

// A start by least squares, or with a curve, would follow a few outliers at an end.
Eigen::MatrixXd robust_fit(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data,
                           double least) {
  constexpr double kSurelyWrong = 6.0;
  const auto absolute = [](double before, double sigmas) {
    return before > 0.0 ? 1.0 / std::max(sigmas, 0.1) : 0.0;
  };
  const Eigen::MatrixXd line = basis.leftCols(std::min<Eigen::Index>(2, basis.cols()));
  Eigen::MatrixXd result(basis.cols(), data.cols());
  for (Eigen::Index column = 0; column < data.cols(); ++column) {
    const Eigen::VectorXd values = data.col(column);
    const Eigen::VectorXd off =
        values -
        line * reweighted(line, values, least, Eigen::VectorXd::Ones(values.size()), absolute);
    const double wrong = kSurelyWrong * residual_sigma(off, least);
    const auto weights_by = [](const Eigen::VectorXd& residuals, const auto& weight) {
      return Eigen::VectorXd(residuals.unaryExpr(weight));
    };
    const Eigen::VectorXd right =
        weights_by(off, [&](double r) { return std::fabs(r) < wrong ? 1.0 : 0.0; });
    const Eigen::VectorXd rest = values - basis * reweighted(basis, values, least, right, absolute);
    const double sigma = residual_sigma(rest, least);
    result.col(column) =
        reweighted(basis, values, least,
                   weights_by(rest, [&](double r) { return biweight(std::fabs(r) / sigma); }),
                   [](double /*before*/, double sigmas) { return biweight(sigmas); });
  }
  return result;
}

double cross_validation_mse(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data) {
  constexpr int kFolds = 5;
  double sum = 0.0;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<bool> keep(static_cast<size_t>(data.rows()));
    for (size_t i = 0; i < keep.size(); ++i) keep[i] = static_cast<int>(i % kFolds) != fold;
    if (std::count(keep.begin(), keep.end(), true) < basis.cols()) return 0.0;
    const Eigen::MatrixXd solution = least_squares(rows_of(basis, keep), rows_of(data, keep));
    const Eigen::MatrixXd residuals = data - basis * solution;
    for (size_t i = 0; i < keep.size(); ++i) {
      if (!keep[i]) sum += residuals.row(static_cast<Eigen::Index>(i)).squaredNorm();
    }
  }
  return sum / static_cast<double>(data.size());
}

}  // namespace raywalk::calibrate
