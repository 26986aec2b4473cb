#include "calibrate/rectify/light_estimate.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

using Solver = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

// Unknowns: the pictures' log light, then the coefficients of the lens terms.
class LightProblem {
 public:
  LightProblem(std::span<const LightSample> samples, int pictures)
      : samples_(samples), pictures_(pictures), weights_(samples.size()) {
    for (std::size_t i = 0; i < samples.size(); ++i) weights_[i] = full_weight(samples[i]);
  }

  Eigen::VectorXd solve() {
    constexpr int kIterations = 30;
    constexpr double kConverged = 1e-7;
    Eigen::VectorXd solution = solve_once();
    for (int i = 0; i < kIterations; ++i) {
      reweight(solution);
      const Eigen::VectorXd last = solution;
      solution = solve_once();
      if ((solution - last).cwiseAbs().maxCoeff() < kConverged) break;
    }
    return solution;
  }

  // The last solution's change by the samples of each part that occurs; one row each, 0 for parts
  // that do not occur.
  Eigen::MatrixXd influence(const Eigen::VectorXd& solution) const {
    Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(unknowns(), kSceneParts);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const LightSample& sample = samples_[i];
      const double pull = weights_[i] * residual(sample, solution);
      auto score = scores.col(sample.part);
      score[sample.to] += pull;
      score[sample.from] -= pull;
      score.tail(kLensTerms) += pull * sample.lens;
    }
    const auto parts = static_cast<double>((scores.colwise().squaredNorm().array() > 0.0).count());
    const Eigen::MatrixXd moved = solver_.solve(scores);
    return std::sqrt(parts / std::max(1.0, parts - 1.0)) * moved.topRows(pictures_).transpose();
  }

 private:
  int unknowns() const { return pictures_ + kLensTerms; }
  static double full_weight(const LightSample& sample) {
    return 1.0 / (sample.error * sample.error);
  }
  static double residual(const LightSample& sample, const Eigen::VectorXd& solution) {
    return sample.log_ratio - (solution[sample.to] - solution[sample.from]) -
           sample.lens.dot(solution.tail(kLensTerms));
  }

  Eigen::VectorXd solve_once() {
    // Weak priors that every unknown is 0: they fix the means of linked pictures, and coefficients
    // that nothing determines.
    constexpr double kPrior = 1e-7;
    std::map<std::pair<int, int>, double> off_diagonal;
    Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(pictures_);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns());
    Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(pictures_, kLensTerms);
    Eigen::Matrix<double, kLensTerms, kLensTerms> lens;
    lens.setZero();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const LightSample& sample = samples_[i];
      const double weight = weights_[i];
      diagonal[sample.from] += weight;
      diagonal[sample.to] += weight;
      off_diagonal[std::minmax(sample.from, sample.to)] -= weight;
      const Eigen::Matrix<double, 1, kLensTerms> terms = weight * sample.lens.transpose();
      mixed.row(sample.to) += terms;
      mixed.row(sample.from) -= terms;
      lens += sample.lens * terms;
      const double pull = weight * sample.log_ratio;
      right[sample.to] += pull;
      right[sample.from] -= pull;
      right.tail(kLensTerms) += pull * sample.lens;
    }
    const double prior = kPrior * std::max(1e-12, diagonal.maxCoeff());
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < pictures_; ++i) {
      entries.emplace_back(i, i, diagonal[i] + prior);
      for (int c = 0; c < kLensTerms; ++c) entries.emplace_back(pictures_ + c, i, mixed(i, c));
    }
    for (const auto& [pair, value] : off_diagonal) {
      entries.emplace_back(pair.second, pair.first, value);
    }
    for (int a = 0; a < kLensTerms; ++a) {
      for (int b = 0; b <= a; ++b) {
        entries.emplace_back(pictures_ + a, pictures_ + b, lens(a, b) + (a == b ? prior : 0.0));
      }
    }
    Eigen::SparseMatrix<double> normal(unknowns(), unknowns());
    normal.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(normal);
    return solver_.solve(right);
  }

  void reweight(const Eigen::VectorXd& solution) {
    constexpr double kTukey = 4.685;  // keeps 95 % of the efficiency under normal errors
    constexpr double kNormalMedian = 0.6745;
    constexpr double kLeastScale = 1e-9;
    std::vector<double> sizes;
    sizes.reserve(samples_.size());
    for (const LightSample& sample : samples_) {
      sizes.push_back(std::abs(residual(sample, solution)) / sample.error);
    }
    const double limit = kTukey * std::max(median(sizes) / kNormalMedian, kLeastScale);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const double share = std::min(1.0, sizes[i] / limit);
      weights_[i] = full_weight(samples_[i]) * (1.0 - share * share) * (1.0 - share * share);
    }
  }

  std::span<const LightSample> samples_;
  int pictures_;
  std::vector<double> weights_;
  Solver solver_;
};

bool in_several_parts(std::span<const LightSample> samples) {
  return std::any_of(samples.begin(), samples.end(), [&](const LightSample& sample) {
    return sample.part != samples.front().part;
  });
}

}  // namespace

LensTerms lens_terms(const Eigen::Vector3d& seen) {
  const double x = seen.x(), y = seen.y(), z = seen.z();
  LensTerms terms;
  terms << x, y, z, x * y, y * z, z * x, x * x - y * y, 3.0 * z * z - 1.0;
  return terms;
}

LightEstimate estimate_light(std::span<const LightSample> samples, int pictures) {
  if (!in_several_parts(samples)) {
    return {Eigen::VectorXd::Zero(pictures), Eigen::MatrixXd::Zero(kSceneParts, pictures)};
  }
  LightProblem problem(samples, pictures);
  const Eigen::VectorXd solution = problem.solve();
  return {solution.head(pictures), problem.influence(solution), solution.tail(kLensTerms)};
}

}  // namespace raywalk::calibrate
