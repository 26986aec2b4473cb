#include "build_lf/gains/gain_solver.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "build_lf/gains/patch_ratios.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

constexpr double kStep = 0.03;
constexpr double kPrior = 0.1;

// One difference of two unknowns.
struct Row {
  int from = 0;
  int to = 0;
  float difference = 0.0F;
  float precision = 0.0F;  // 1 / error^2
};

bool is_part(Part part, int patch) {
  if (part == Part::kAll) return true;
  const bool black = (patch % kPatches / kPatchesPhi + patch % kPatchesPhi) % 2 == 0;
  return black == (part == Part::kBlack);
}

// The weighted normal equations (A' W A + D) x = A' W b, applied row by row: the matrix is never
// stored.
class NormalEquations {
 public:
  NormalEquations(std::vector<Row> rows, Eigen::Index unknowns)
      : rows_(std::move(rows)), weights_(rows_.size()), unknowns_(unknowns) {
    for (size_t i = 0; i < rows_.size(); ++i) weights_[i] = rows_[i].precision;
  }

  // Huber's weights for the residuals of `x`.
  void reweight(const Eigen::VectorXd& x) {
    constexpr double kHuber = 1.345;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      const double precision = row.precision;
      const double residual =
          std::fabs(x[row.from] - x[row.to] - double{row.difference}) * std::sqrt(precision);
      weights_[i] =
          static_cast<float>(precision * std::min(1.0, kHuber / std::max(residual, kHuber)));
    }
  }

  Eigen::VectorXd right_side() const {
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns_);
    for (size_t i = 0; i < rows_.size(); ++i) {
      const double push = double{weights_[i]} * double{rows_[i].difference};
      right[rows_[i].from] += push;
      right[rows_[i].to] -= push;
    }
    return right;
  }

  Eigen::VectorXd diagonal() const {
    Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(unknowns_, 1.0 / (kPrior * kPrior));
    for (size_t i = 0; i < rows_.size(); ++i) {
      diagonal[rows_[i].from] += double{weights_[i]};
      diagonal[rows_[i].to] += double{weights_[i]};
    }
    return diagonal;
  }

  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const {
    Eigen::VectorXd result = x / (kPrior * kPrior);
    for (size_t i = 0; i < rows_.size(); ++i) {
      const double push = double{weights_[i]} * (x[rows_[i].from] - x[rows_[i].to]);
      result[rows_[i].from] += push;
      result[rows_[i].to] -= push;
    }
    return result;
  }

 private:
  std::vector<Row> rows_;
  std::vector<float> weights_;
  Eigen::Index unknowns_;
};

// Conjugate gradients, preconditioned by the diagonal (Shewchuk 1994, B3), from the guess in `x`.
void solve(const NormalEquations& normal, Eigen::VectorXd* x) {
  constexpr double kTolerance = 1e-4;
  constexpr int kMaxIterations = 500;
  const Eigen::VectorXd right = normal.right_side();
  const Eigen::VectorXd inverse_diagonal = normal.diagonal().cwiseInverse();
  Eigen::VectorXd residual = right - normal * *x;
  Eigen::VectorXd direction = inverse_diagonal.cwiseProduct(residual);
  double product = residual.dot(direction);
  const double small = kTolerance * right.norm();
  for (int i = 0; i < kMaxIterations && residual.norm() > small; ++i) {
    const Eigen::VectorXd image = normal * direction;
    const double step = product / direction.dot(image);
    *x += step * direction;
    residual -= step * image;
    const Eigen::VectorXd preconditioned = inverse_diagonal.cwiseProduct(residual);
    const double next = residual.dot(preconditioned);
    direction = preconditioned + next / product * direction;
    product = next;
  }
}

float precision_of(double error) { return static_cast<float>(1.0 / (error * error)); }

void add_neighbours(int stations, std::vector<Row>* rows) {
  constexpr double kNarrowest = 0.1;
  for (int station = 0; station < stations; ++station) {
    const int first = station * kPatches;
    for (int theta = 0; theta < kPatchesTheta; ++theta) {
      for (int phi = 0; phi < kPatchesPhi; ++phi) {
        const int here = first + theta * kPatchesPhi + phi;
        const int beside = first + (theta + 1) % kPatchesTheta * kPatchesPhi + phi;
        const double width = std::max(kNarrowest, std::sin((phi + 0.5) / kPatchesPhi * kPi));
        rows->push_back({here, beside, 0.0F, precision_of(kStep * width)});
        if (phi + 1 < kPatchesPhi) rows->push_back({here, here + 1, 0.0F, precision_of(kStep)});
      }
    }
  }
}

}  // namespace

std::vector<double> solve_patch_gains(std::span<const PatchEquation> equations, Part part,
                                      size_t channel, int stations) {
  std::vector<Row> rows;
  rows.reserve(equations.size() + static_cast<size_t>(2 * stations * kPatches));
  for (const PatchEquation& equation : equations) {
    if (!is_part(part, equation.from)) continue;
    rows.push_back({equation.from, equation.to, equation.difference[channel],
                    precision_of(static_cast<double>(equation.error[channel]))});
  }
  add_neighbours(stations, &rows);
  const Eigen::Index unknowns = static_cast<Eigen::Index>(stations) * kPatches;
  NormalEquations normal(std::move(rows), unknowns);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  constexpr int kReweightings = 12;
  constexpr double kConverged = 1e-3;
  for (int i = 0; i < kReweightings; ++i) {
    const Eigen::VectorXd last = x;
    solve(normal, &x);
    if (i > 0 && (x - last).cwiseAbs().maxCoeff() < kConverged) break;
    normal.reweight(x);
  }
  return {x.data(), x.data() + x.size()};
}

}  // namespace raywalk::build_lf
