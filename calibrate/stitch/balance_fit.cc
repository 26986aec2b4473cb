#include "calibrate/stitch/balance_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "calibrate/base/cauchy_loss.h"
#include "core/base/median.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

// The unknowns: gains of blue, green and red, falloff_2, falloff_4, then an exposure per pair of
// frames.
constexpr int kFalloff = 3;
constexpr int kExposures = 5;
constexpr int kRounds = 12;

// Standard deviations of the priors, of logarithms of light. falloff_2 t^2 is -0.7 at the rim (half
// of the light) for -0.28, falloff_4 t^4 for -0.11.
constexpr double kGainPrior = 1.0;
constexpr double kFalloff2Prior = 0.3;
constexpr double kFalloff4Prior = 0.1;
// Lower bound of the scatter: the rounding of levels.
constexpr double kLeastScatter = 1e-3;

double square(double x) { return x * x; }

// The coefficients of a ratio's equation that are common to all colours.
struct Equation {
  double back;       // -1, 0 or 1: second is in the back lens minus first is
  double falloff_2;  // difference of t^2
  double falloff_4;
  std::optional<int> exposure;  // index of the unknown
};

Equation equation_of(const LightRatio& ratio) {
  const double first = square(ratio.first.angle_rad), second = square(ratio.second.angle_rad);
  return {static_cast<double>(ratio.second.back) - static_cast<double>(ratio.first.back),
          second - first, square(second) - square(first),
          ratio.frames ? std::optional(kExposures + *ratio.frames) : std::nullopt};
}

class NormalEquations {
 public:
  explicit NormalEquations(int unknowns)
      : matrix_(Eigen::MatrixXd::Zero(unknowns, unknowns)),
        right_(Eigen::VectorXd::Zero(unknowns)) {
    for (int i = 0; i < unknowns; ++i) matrix_(i, i) = 1.0 / square(kGainPrior);
    matrix_(kFalloff, kFalloff) = 1.0 / square(kFalloff2Prior);
    matrix_(kFalloff + 1, kFalloff + 1) = 1.0 / square(kFalloff4Prior);
  }

  void add(const Equation& equation, int colour, double measured, double information) {
    const std::array<int, 4> at{colour, kFalloff, kFalloff + 1, equation.exposure.value_or(0)};
    const std::array<double, 4> by{equation.back, equation.falloff_2, equation.falloff_4,
                                   equation.exposure ? 1.0 : 0.0};
    for (std::size_t i = 0; i < at.size(); ++i) {
      for (std::size_t j = 0; j < at.size(); ++j) {
        matrix_(at[i], at[j]) += information * by[i] * by[j];
      }
      right_(at[i]) += information * by[i] * measured;
    }
  }

  Eigen::VectorXd solution() const { return matrix_.ldlt().solve(right_); }
  Eigen::MatrixXd covariance() const {
    return matrix_.ldlt().solve(Eigen::MatrixXd::Identity(matrix_.rows(), matrix_.cols()));
  }

 private:
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
};

double residual_of(const Equation& equation, int colour, double measured,
                   const Eigen::VectorXd& unknowns) {
  return measured - equation.back * unknowns(colour) - equation.falloff_2 * unknowns(kFalloff) -
         equation.falloff_4 * unknowns(kFalloff + 1) -
         (equation.exposure ? unknowns(*equation.exposure) : 0.0);
}

double scatter_of(const std::vector<LightRatio>& ratios, const Eigen::VectorXd& unknowns) {
  std::vector<double> deviations;
  deviations.reserve(3 * ratios.size());
  for (const LightRatio& ratio : ratios) {
    const Equation equation = equation_of(ratio);
    for (int colour = 0; colour < 3; ++colour) {
      const double measured = ratio.log_light[static_cast<std::size_t>(colour)];
      deviations.push_back(std::abs(residual_of(equation, colour, measured, unknowns)));
    }
  }
  return std::max(robust_sigma(std::move(deviations)), kLeastScatter);
}

NormalEquations equations_about(const std::vector<LightRatio>& ratios,
                                const Eigen::VectorXd& unknowns, double scatter) {
  NormalEquations normal(static_cast<int>(unknowns.size()));
  for (const LightRatio& ratio : ratios) {
    const Equation equation = equation_of(ratio);
    for (int colour = 0; colour < 3; ++colour) {
      const double measured = ratio.log_light[static_cast<std::size_t>(colour)];
      const double off =
          residual_of(equation, colour, measured, unknowns) / (kCauchySigmas * scatter);
      normal.add(equation, colour, measured, 1.0 / (square(scatter) * (1.0 + square(off))));
    }
  }
  return normal;
}

// Sigma of ln share at an angle, which is linear in the two coefficients.
double share_sigma(const Eigen::MatrixXd& covariance, double angle_rad) {
  const Eigen::Vector2d by(square(angle_rad), square(square(angle_rad)));
  return std::sqrt(by.dot(covariance.block<2, 2>(kFalloff, kFalloff) * by));
}

}  // namespace

BalanceFit fit_balance(const std::vector<LightRatio>& ratios) {
  int unknown_count = kExposures;
  for (const LightRatio& ratio : ratios) {
    unknown_count = std::max(unknown_count, kExposures + ratio.frames.value_or(-1) + 1);
  }
  BalanceFit fit;
  fit.ratios = static_cast<int>(ratios.size());
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(unknown_count);
  NormalEquations normal(unknown_count);
  for (int round = 0; round < kRounds && !ratios.empty(); ++round) {
    fit.scatter = scatter_of(ratios, unknowns);
    normal = equations_about(ratios, unknowns, fit.scatter);
    unknowns = normal.solution();
  }
  for (std::size_t colour = 0; colour < 3; ++colour) {
    fit.balance.back_gain[colour] = std::exp(unknowns(static_cast<int>(colour)));
  }
  fit.balance.falloff_2 = unknowns(kFalloff);
  fit.balance.falloff_4 = unknowns(kFalloff + 1);
  const Eigen::MatrixXd covariance = normal.covariance();
  fit.gain_sigma = std::sqrt(covariance(1, 1));
  fit.share_45_sigma = share_sigma(covariance, 0.25 * kPi);
  fit.share_90_sigma = share_sigma(covariance, kHalfPi);
  return fit;
}

}  // namespace raywalk::calibrate
