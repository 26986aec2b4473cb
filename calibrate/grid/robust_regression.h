// Least squares in given functions, plain and such that wrong samples do not count.
#pragma once

#include <Eigen/Core>

namespace raywalk::calibrate {

// In all: `basis` is samples x functions, the second of which, if there are as many, makes a
// straight line with the first; `data` is samples x components, each fitted by itself; the result
// is functions x components.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data);

// Least absolute deviations from a straight line tell which samples cannot be right; without them,
// those from all functions; last, what Tukey's redescending weights make of it. `least` is a
// scatter below which there is none.
Eigen::MatrixXd robust_fit(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data, double least);

// robust_sigma of residuals about 0; at least `least`.
double residual_sigma(const Eigen::VectorXd& residuals, double least);

// Mean square of the residuals of samples left out of a least-squares fit, in five interleaved
// folds; 0 where there are too few samples to leave any out.
double left_out_square(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data);

}  // namespace raywalk::calibrate
