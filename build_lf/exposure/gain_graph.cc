#include "build_lf/exposure/gain_graph.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace raywalk::build_lf {
namespace {

// Weighted least squares. The normal matrix is a graph Laplacian, singular in the mean of every
// connected component. The right side sums to 0 over each component, so adding a small multiple of
// the identity makes the system regular and each component's mean 0. The multiple amplifies
// rounding errors, to less than 1e-6 here.
Eigen::VectorXd solve_weighted(const std::vector<GainEquation>& equations,
                               const std::vector<double>& weights, int pictures) {
  constexpr double kRegularisation = 1e-9;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(pictures) + 4 * equations.size());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(pictures);
  double max_weight = 1.0;
  for (std::size_t i = 0; i < equations.size(); ++i) {
    const auto [from, to, difference, error] = equations[i];
    const double weight = weights[i];
    entries.emplace_back(from, from, weight);
    entries.emplace_back(to, to, weight);
    entries.emplace_back(from, to, -weight);
    entries.emplace_back(to, from, -weight);
    right[from] += weight * difference;
    right[to] -= weight * difference;
    max_weight = std::max(max_weight, weight);
  }
  const double diagonal = kRegularisation * max_weight;
  for (int i = 0; i < pictures; ++i) entries.emplace_back(i, i, diagonal);
  Eigen::SparseMatrix<double> normal(pictures, pictures);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(normal);
  return factors.solve(right);
}

}  // namespace

Eigen::VectorXd solve_gain_graph(const std::vector<GainEquation>& equations, int pictures) {
  constexpr double kHuber = 1.345;
  constexpr int kMaxIterations = 50;
  constexpr double kConverged = 1e-6;
  std::vector<double> weights;
  weights.reserve(equations.size());
  for (const GainEquation& equation : equations) {
    weights.push_back(1.0 / (equation.error * equation.error));
  }
  Eigen::VectorXd solution = solve_weighted(equations, weights, pictures);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    for (std::size_t i = 0; i < equations.size(); ++i) {
      const GainEquation& equation = equations[i];
      const double residual =
          std::fabs(solution[equation.from] - solution[equation.to] - equation.difference) /
          equation.error;
      weights[i] =
          std::min(1.0, kHuber / std::max(residual, kHuber)) / (equation.error * equation.error);
    }
    const Eigen::VectorXd last = solution;
    solution = solve_weighted(equations, weights, pictures);
    if (pictures == 0 || (solution - last).cwiseAbs().maxCoeff() < kConverged) break;
  }
  return solution;
}

}  // namespace raywalk::build_lf
