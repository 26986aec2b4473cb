#include "calibrate/grid/normal_inverse.h"

#include "core/base/error.h"

namespace raywalk::calibrate {

// Unknowns in metres and radians are scaled to unit diagonal first.
NormalInverse::NormalInverse(const Eigen::SparseMatrix<double>& jacobian)
    : scale_(Eigen::VectorXd::Ones(jacobian.cols())) {
  for (int column = 0; column < jacobian.outerSize(); ++column) {
    const double length = jacobian.col(column).norm();
    held_.push_back(!(length > 0.0));
    if (length > 0.0) scale_[column] = 1.0 / length;
  }
  const Eigen::SparseMatrix<double> scaled = jacobian * scale_.asDiagonal();
  Eigen::SparseMatrix<double> normal = scaled.transpose() * scaled;
  for (int column = 0; column < normal.outerSize(); ++column) {
    if (held_[static_cast<size_t>(column)]) normal.coeffRef(column, column) = 1.0;
  }
  factors_.compute(normal);
  if (factors_.info() != Eigen::Success) {
    throw Error(
        "the estimate's covariance cannot be computed: the normal equations are singular; solve "
        "the poses again");
  }
}

Eigen::MatrixXd NormalInverse::of(const Eigen::MatrixXd& combinations) const {
  Eigen::MatrixXd scaled = scale_.asDiagonal() * combinations;
  for (Eigen::Index row = 0; row < scaled.rows(); ++row) {
    if (held_[static_cast<size_t>(row)]) scaled.row(row).setZero();
  }
  return scaled.transpose() * factors_.solve(scaled);
}

}  // namespace raywalk::calibrate
