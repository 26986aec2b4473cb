#include "build_lf/exposure/gain_solver.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
      : rows_(std::move(rows)), unknowns_(unknowns) {
    terms_.reserve(rows_.size());
    for (const Row& row : rows_) terms_.push_back({row.from, row.to, row.precision});
  }

  // Huber's weights for the residuals of `x`.
  void reweight(const Eigen::VectorXd& x) {
    constexpr double kHuber = 1.345;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      const double precision = row.precision;
      const double residual =
          std::fabs(x[row.from] - x[row.to] - double{row.difference}) * std::sqrt(precision);
      terms_[i].weight =
          static_cast<float>(precision * std::min(1.0, kHuber / std::max(residual, kHuber)));
    }
  }

  Eigen::VectorXd right_side() const {
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns_);
    for (size_t i = 0; i < rows_.size(); ++i) {
      const double push = double{terms_[i].weight} * double{rows_[i].difference};
      right[rows_[i].from] += push;
      right[rows_[i].to] -= push;
    }
    return right;
  }

  Eigen::VectorXd diagonal() const {
    Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(unknowns_, 1.0 / (kPrior * kPrior));
    for (const Term& term : terms_) {
      diagonal[term.from] += double{term.weight};
      diagonal[term.to] += double{term.weight};
    }
    return diagonal;
  }

  Eigen::VectorXd operator*(const Eigen::VectorXd& x) const {
    Eigen::VectorXd result = x / (kPrior * kPrior);
    for (const Term& term : terms_) {
      const double push = double{term.weight} * (x[term.from] - x[term.to]);
      result[term.from] += push;
      result[term.to] -= push;
    }
    return result;
  }

 private:
  // What the product with the matrix reads of a row, which is what the time goes into.
  struct Term {
    int from = 0;
    int to = 0;
    float weight = 0.0F;
  };
  std::vector<Row> rows_;
  std::vector<Term> terms_;
  Eigen::Index unknowns_;
};

// Conjugate gradients, preconditioned by the diagonal (Shewchuk 1994, B3), from the guess in `x`,
// until the residual is `tolerance` times the right side.
void solve(const NormalEquations& normal, double tolerance, Eigen::VectorXd* x) {
  constexpr int kMaxIterations = 500;
  const Eigen::VectorXd right = normal.right_side();
  const Eigen::VectorXd inverse_diagonal = normal.diagonal().cwiseInverse();
  Eigen::VectorXd residual = right - normal * *x;
  Eigen::VectorXd direction = inverse_diagonal.cwiseProduct(residual);
  double product = residual.dot(direction);
  const double small = tolerance * right.norm();
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

constexpr int kSolverSteps = 2;  // from one station to those it is compared with

using Groups = std::vector<std::vector<int>>;

void halve(std::span<const Eigen::Vector3d> positions_m, std::vector<int> stations,
           std::size_t most, Groups* groups) {
  if (stations.size() <= most) {
    std::ranges::sort(stations);
    groups->push_back(std::move(stations));
    return;
  }
  Eigen::AlignedBox3d box;
  for (const int s : stations) box.extend(positions_m[static_cast<size_t>(s)]);
  const Eigen::Index axis = box.sizes().x() > box.sizes().z() ? 0 : 2;
  std::ranges::sort(stations, {}, [&](int s) {
    return std::make_pair(positions_m[static_cast<size_t>(s)][axis], s);
  });
  const auto middle = stations.begin() + static_cast<std::ptrdiff_t>(stations.size() / 2);
  halve(positions_m, {stations.begin(), middle}, most, groups);
  halve(positions_m, {middle, stations.end()}, most, groups);
}

}  // namespace

Eigen::MatrixXd solve_patch_gains(std::span<const PatchRatio> ratios, Part part, size_t channel,
                                  int stations, const Eigen::MatrixXd& guess) {
  std::vector<Row> rows;
  rows.reserve(ratios.size() + static_cast<size_t>(2 * stations * kPatches));
  for (const PatchRatio& ratio : ratios) {
    if (!is_part(part, ratio.from)) continue;
    rows.push_back({ratio.from, ratio.to, ratio.log_ratio[channel],
                    precision_of(static_cast<double>(ratio.error[channel]))});
  }
  add_neighbours(stations, &rows);
  const Eigen::Index unknowns = static_cast<Eigen::Index>(stations) * kPatches;
  NormalEquations normal(std::move(rows), unknowns);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  if (guess.size() > 0) {
    x = guess.reshaped();
    normal.reweight(x);
  }
  constexpr int kReweightings = 12;
  constexpr double kConverged = 1e-3;
  // The first weights are far from the last ones: solving for them exactly would be in vain.
  constexpr double kFinalTolerance = 1e-4;
  double tolerance = 1e-2;
  for (int i = 0; i < kReweightings; ++i) {
    const Eigen::VectorXd last = x;
    solve(normal, tolerance, &x);
    const bool exact = tolerance <= kFinalTolerance;
    if (exact && (x - last).cwiseAbs().maxCoeff() < kConverged) break;
    tolerance = std::max(kFinalTolerance, 0.2 * tolerance);
    normal.reweight(x);
  }
  return x.reshaped(kPatches, stations);
}

std::vector<GainWindow> gain_windows(std::span<const Eigen::Vector3d> positions_m,
                                     std::span<const WholeRatio> pairs, int most) {
  std::vector<int> all(positions_m.size());
  std::iota(all.begin(), all.end(), 0);
  Groups groups;
  halve(positions_m, std::move(all), static_cast<size_t>(most), &groups);
  Groups compared(positions_m.size());
  for (const WholeRatio& pair : pairs) compared[static_cast<size_t>(pair.to)].push_back(pair.from);
  std::vector<GainWindow> windows;
  for (const std::vector<int>& group : groups) {
    std::vector<int> members = group;
    for (int step = 0; step < kSolverSteps; ++step) {
      std::vector<int> around;
      for (const int s : members) {
        const std::vector<int>& others = compared[static_cast<size_t>(s)];
        around.insert(around.end(), others.begin(), others.end());
      }
      members.insert(members.end(), around.begin(), around.end());
      std::ranges::sort(members);
      members.erase(std::unique(members.begin(), members.end()), members.end());
    }
    GainWindow& window = windows.emplace_back();
    window.stations = std::move(members);
    for (const int s : window.stations) {
      window.kept.push_back(std::binary_search(group.begin(), group.end(), s));
    }
  }
  return windows;
}

}  // namespace raywalk::build_lf
