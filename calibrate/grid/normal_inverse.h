// The covariance of a least-squares problem's unknowns, from the derivatives of its residuals.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace raywalk::calibrate {

// Solves with the normal equations to get the covariance of selected combinations of unknowns.
class NormalInverse {
 public:
  // Rows are residuals divided by their standard deviations. An unknown whose column is empty is
  // constant and has zero variance. Throws Error where the unknowns are not determined.
  explicit NormalInverse(const Eigen::SparseMatrix<double>& jacobian);

  // The covariance of linear combinations of the unknowns, the columns of `combinations`.
  Eigen::MatrixXd of(const Eigen::MatrixXd& combinations) const;

 private:
  Eigen::VectorXd scale_;
  std::vector<bool> held_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

}  // namespace raywalk::calibrate
