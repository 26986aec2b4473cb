#include "calibrate/rectify/exposure_decision.h"

#include <Eigen/QR>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

// Columns that span the light a model allows; none for kEqual.
Eigen::MatrixXd basis_of(ExposureModel model, std::span<const PictureLine> lines, int pictures) {
  const auto count = static_cast<Eigen::Index>(lines.size());
  if (model == ExposureModel::kEqual) return Eigen::MatrixXd::Zero(pictures, 0);
  if (model == ExposureModel::kStations) return Eigen::MatrixXd::Identity(pictures, pictures);
  const bool drift = model == ExposureModel::kDrift;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(pictures, drift ? 2 * count : count);
  for (Eigen::Index l = 0; l < count; ++l) {
    const PictureLine& line = lines[static_cast<std::size_t>(l)];
    double middle_m = 0.0;
    for (const double along_m : line.along_m) {
      middle_m += along_m / static_cast<double>(line.along_m.size());
    }
    for (std::size_t i = 0; i < line.pictures.size(); ++i) {
      basis(line.pictures[i], l) = 1.0;
      if (drift) basis(line.pictures[i], count + l) = line.along_m[i] - middle_m;
    }
  }
  return basis;
}

// The matrix that maps measured light to the model's least-squares fit.
Eigen::MatrixXd projection_to(const Eigen::MatrixXd& basis) {
  if (basis.cols() == 0) return Eigen::MatrixXd::Zero(basis.rows(), basis.rows());
  return basis * basis.completeOrthogonalDecomposition().pseudoInverse();
}

// A picture less the mean of others; 0 if the model holds.
struct Deviation {
  int picture = 0;
  std::vector<int> others{};

  Eigen::VectorXd of(const Eigen::MatrixXd& columns) const {
    Eigen::VectorXd left = columns.col(picture);
    for (const int other : others) left -= columns.col(other) / static_cast<double>(others.size());
    return left;
  }
};

// Every picture, and every picture less the mean of its neighbours.
std::vector<Deviation> deviations_of(std::span<const PictureLine> lines) {
  std::vector<Deviation> deviations;
  for (const PictureLine& line : lines) {
    for (std::size_t i = 0; i < line.pictures.size(); ++i) {
      deviations.push_back({.picture = line.pictures[i]});
      if (line.pictures.size() == 1) continue;
      Deviation local = deviations.back();
      if (i > 0) local.others.push_back(line.pictures[i - 1]);
      if (i + 1 < line.pictures.size()) local.others.push_back(line.pictures[i + 1]);
      deviations.push_back(local);
    }
  }
  return deviations;
}

ModelTest test_of(ExposureModel model, const UncertainLight& light,
                  const Eigen::MatrixXd& projection, const std::vector<Deviation>& deviations,
                  double t_limit) {
  const Eigen::MatrixXd left = (light.value - projection * light.value).transpose();
  const Eigen::MatrixXd errors = light.errors - light.errors * projection.transpose();
  ModelTest test{.model = model};
  for (const Deviation& deviation : deviations) {
    // Where the model leaves nothing, as with two pictures and a drift, there is no deviation.
    constexpr double kNothing = 1e-12;
    const double size = deviation.of(left).norm();
    if (size < kNothing) continue;
    const double t = size / deviation.of(errors).norm();
    if (t <= test.largest_t) continue;
    test.largest_t = t;
    test.picture = deviation.picture;
  }
  test.rejected = test.largest_t > t_limit;
  return test;
}

void take_model(ExposureModel model, const UncertainLight& light, const Eigen::MatrixXd& projection,
                ExposureDecision* decision) {
  decision->model = model;
  decision->fitted = projection * light.value;
  const Eigen::MatrixXd errors = light.errors * projection.transpose();
  decision->error = errors.colwise().norm();
  decision->correction = Eigen::VectorXd::Zero(light.value.size());
  for (Eigen::Index i = 0; i < light.value.size(); ++i) {
    if (std::abs(decision->fitted[i]) > decision->t_limit_single * decision->error[i]) {
      decision->correction[i] = decision->fitted[i];
    }
  }
}

// The integral of cos^power from `from` to pi / 2, by Simpson's rule.
double integral_of_power(double from, double power) {
  constexpr int kIntervals = 400;
  const double step = (kHalfPi - from) / kIntervals;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * std::pow(std::cos(std::min(from + i * step, kHalfPi)), power);
  }
  return sum * step / 3.0;
}

}  // namespace

const char* exposure_model_name(ExposureModel model) {
  switch (model) {
    case ExposureModel::kEqual:
      return "equal";
    case ExposureModel::kLines:
      return "lines";
    case ExposureModel::kDrift:
      return "drift";
    case ExposureModel::kStations:
      return "stations";
  }
  return "";
}

ExposureDecision decide_exposures(const UncertainLight& light, std::span<const PictureLine> lines) {
  const auto pictures = static_cast<int>(light.value.size());
  const std::vector<Deviation> deviations = deviations_of(lines);
  ExposureDecision decision;
  decision.measured = light.value;
  decision.fitted = decision.error = decision.correction = Eigen::VectorXd::Zero(pictures);
  if (light.freedom < 1 || deviations.empty()) return decision;
  decision.t_limit =
      two_sided_quantile(kSignificance / static_cast<double>(deviations.size()), light.freedom);
  decision.t_limit_single = two_sided_quantile(kSignificance, light.freedom);
  for (const ExposureModel model :
       {ExposureModel::kEqual, ExposureModel::kLines, ExposureModel::kDrift}) {
    const Eigen::MatrixXd projection = projection_to(basis_of(model, lines, pictures));
    decision.tests.push_back(test_of(model, light, projection, deviations, decision.t_limit));
    if (decision.tests.back().rejected) continue;
    take_model(model, light, projection, &decision);
    if (model == ExposureModel::kEqual) decision.error = light.errors.colwise().norm();
    return decision;
  }
  take_model(ExposureModel::kStations, light, Eigen::MatrixXd::Identity(pictures, pictures),
             &decision);
  return decision;
}

// With t = sqrt(freedom) tan(a) the density is proportional to cos(a)^(freedom - 1).
double two_sided_probability(double size, int freedom) {
  const double from = std::atan(size / std::sqrt(static_cast<double>(freedom)));
  return integral_of_power(from, freedom - 1.0) / integral_of_power(0.0, freedom - 1.0);
}

double two_sided_quantile(double probability, int freedom) {
  constexpr int kHalvings = 60;
  double low = 0.0, high = 1.0;
  while (two_sided_probability(high, freedom) > probability) high *= 2.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (two_sided_probability(middle, freedom) > probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace raywalk::calibrate
