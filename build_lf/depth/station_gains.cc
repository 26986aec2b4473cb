#include "build_lf/depth/station_gains.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace raywalk {
namespace {

// Numbers all stations, line after line.
class StationNumbers {
 public:
  explicit StationNumbers(const Grid& grid) {
    for (const Line& line : grid.lines) {
      first_.push_back(count_);
      count_ += static_cast<int>(line.stations.size());
    }
  }
  int of(StationIndex station) const {
    return first_[static_cast<size_t>(station.line)] + station.station;
  }
  int count() const { return count_; }

 private:
  std::vector<int> first_;
  int count_ = 0;
};

// log gain(from) - log gain(to) = difference, known to within `error`.
struct GainEquation {
  int from = 0;
  int to = 0;
  double difference = 0.0;
  double error = 1.0;
  double weight = 1.0;
};

// Weighted least squares. The normal equations are those of a graph: they leave the mean of every
// connected part open. Their right side sums to 0 over each part, so with a vanishing multiple of
// the unit matrix added, which makes them regular, each part's mean comes out as exactly 0.
Eigen::VectorXd solve_weighted(const std::vector<GainEquation>& equations, int unknowns) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  double most_weight = 1.0;
  for (const GainEquation& equation : equations) {
    const auto [from, to, difference, error, weight] = equation;
    entries.emplace_back(from, from, weight);
    entries.emplace_back(to, to, weight);
    entries.emplace_back(from, to, -weight);
    entries.emplace_back(to, from, -weight);
    right[from] += weight * difference;
    right[to] -= weight * difference;
    most_weight = std::max(most_weight, weight);
  }
  constexpr double kVanishing = 1e-12;
  for (int i = 0; i < unknowns; ++i) entries.emplace_back(i, i, kVanishing * most_weight);
  Eigen::SparseMatrix<double> normal(unknowns, unknowns);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(normal);
  return factors.solve(right);
}

// Huber's estimate by iterative reweighting: a residual r of more than k standard errors s counts
// as k s |r|, not r^2, so a wrong link pulls no harder the more it is wrong (k = 1.345 keeps 95 %
// of the efficiency of least squares under normal errors; Huber 1981).
Eigen::VectorXd solve_robustly(std::vector<GainEquation> equations, int unknowns) {
  constexpr double kHuber = 1.345;
  constexpr int kMostIterations = 50;
  constexpr double kConverged = 1e-6;
  for (GainEquation& equation : equations) {
    equation.weight = 1.0 / (equation.error * equation.error);
  }
  Eigen::VectorXd solution = solve_weighted(equations, unknowns);
  for (int i = 0; i < kMostIterations; ++i) {
    for (GainEquation& equation : equations) {
      const double residual =
          std::fabs(solution[equation.from] - solution[equation.to] - equation.difference) /
          equation.error;
      equation.weight =
          std::min(1.0, kHuber / std::max(residual, kHuber)) / (equation.error * equation.error);
    }
    const Eigen::VectorXd last = solution;
    solution = solve_weighted(equations, unknowns);
    if ((solution - last).cwiseAbs().maxCoeff() < kConverged) break;
  }
  return solution;
}

}  // namespace

StationGains solve_gains(const Grid& grid, std::span<const StationLink> links) {
  const StationNumbers numbers(grid);
  StationGains result;
  for (const Line& line : grid.lines) {
    result.gain.emplace_back(line.stations.size(), ColourGain(1.0f, 1.0f, 1.0f));
  }
  for (size_t channel = 0; channel < 3; ++channel) {
    std::vector<GainEquation> equations;
    for (const StationLink& link : links) {
      if (!link.comparable) continue;
      const int from = numbers.of(link.pair.from);
      const int to = numbers.of(link.pair.to);
      equations.push_back({from, to, link.log_ratio[channel], link.log_ratio_error[channel]});
    }
    const Eigen::VectorXd log_gain = solve_robustly(std::move(equations), numbers.count());
    for (size_t line = 0; line < result.gain.size(); ++line) {
      for (size_t i = 0; i < result.gain[line].size(); ++i) {
        const int number = numbers.of({static_cast<int>(line), static_cast<int>(i)});
        result.gain[line][i][static_cast<int>(channel)] =
            static_cast<float>(std::exp(log_gain[number]));
      }
    }
  }
  return result;
}

// Levels times gain agree, so levels change as gains do the other way round.
double log_exposure_step(std::span<const ColourGain> gains, int station) {
  const ColourGain& before = gains[static_cast<size_t>(station) - 1];
  const ColourGain& after = gains[static_cast<size_t>(station)];
  double largest = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double step = std::log(static_cast<double>(before[c]) / after[c]);
    if (std::fabs(step) > std::fabs(largest)) largest = step;
  }
  return largest;
}

}  // namespace raywalk
