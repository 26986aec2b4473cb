// Linear regression in given basis functions, by least squares and robust to outliers.
#pragma once

#include <Eigen/Core>

namespace raywalk::calibrate {

// For all functions here: `basis` is samples x functions, of which the first two (if there are two)
// span straight lines; `data` is samples x components, fitted independently; the result is
// functions x components.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data);

// Robust fit in three steps: a straight line by least absolute deviations, to find gross outliers;
// all functions by least absolute deviations without them; then Tukey's biweight. `least` is the
// lower bound of the scatter.
Eigen::MatrixXd robust_fit(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data, double least);

// robust_sigma of residuals about 0; at least `least`.
double residual_sigma(const Eigen::VectorXd& residuals, double least);

// Mean squared residual by cross-validation of a least-squares fit, in five interleaved folds; 0
// where there are too few samples.
double cross_validation_mse(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data);

}  // namespace raywalk::calibrate
