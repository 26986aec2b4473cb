#include "calibrate/grid/rail_fit.h"

#include <algorithm>
#include <cmath>

#include "calibrate/grid/robust_regression.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// Compares nested models (leading columns of `basis`) by the Bayesian information criterion. `unit`
// converts residuals for the report. Returns the index of the selected model.
int choose_model(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data,
                 std::span<const Eigen::Index> columns, std::span<const char* const> names,
                 double least, double unit, std::vector<RailModelScore>* scores) {
  const auto samples = static_cast<double>(data.rows());
  const auto components = static_cast<double>(data.cols());
  int best = 0;
  for (size_t model = 0; model < columns.size(); ++model) {
    const Eigen::Index count = columns[model];
    // With too few samples a model fits their noise.
    if (model > 0 && data.rows() < 2 * count + 2) break;
    const Eigen::MatrixXd part = basis.leftCols(count);
    const Eigen::MatrixXd residuals = data - part * least_squares(part, data);
    const double square =
        std::max(least * least, residuals.squaredNorm() / static_cast<double>(data.size()));
    const double parameters = components * static_cast<double>(count);
    const double bic =
        samples * components * std::log(square) + parameters * std::log(std::max(2.0, samples));
    scores->push_back({.name = names[model],
                       .parameters = static_cast<int>(parameters),
                       .residual = unit * std::sqrt(square),
                       .left_out = unit * std::sqrt(cross_validation_mse(part, data)),
                       .bic = bic});
    if (bic < (*scores)[static_cast<size_t>(best)].bic) best = static_cast<int>(model);
  }
  (*scores)[static_cast<size_t>(best)].kept = true;
  return best;
}

Eigen::MatrixXd legendre_basis(const RailFrame& frame, std::span<const RailSample> samples,
                               Eigen::Index functions) {
  Eigen::MatrixXd basis(static_cast<Eigen::Index>(samples.size()), functions);
  for (size_t i = 0; i < samples.size(); ++i) {
    const double u = frame.u_of(samples[i].rail_m);
    const std::array<double, 4> values{1.0, u, legendre2(u), legendre3(u)};
    for (Eigen::Index j = 0; j < functions; ++j) {
      basis(static_cast<Eigen::Index>(i), j) = values[static_cast<size_t>(j)];
    }
  }
  return basis;
}

// The number of basis functions that the samples support, at most `most`.
Eigen::Index functions_for(size_t samples, Eigen::Index most) {
  const auto count = static_cast<Eigen::Index>(samples);
  if (count < 3) return 1;
  return std::min(most, std::max<Eigen::Index>(2, (count - 2) / 2));
}

// Deviations of the samples from a straight rail with the given parameters, in the rail's axes:
// along, across, up.
Eigen::MatrixXd in_rail_axes(const RailFrame& frame, const RailParameters& straight,
                             std::span<const RailSample> samples) {
  const RailAxes<double> axes = rail_axes(frame.axis, straight[P::kHeading], straight[P::kTilt]);
  Eigen::MatrixXd data(static_cast<Eigen::Index>(samples.size()), 3);
  for (size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d off =
        samples[i].position_m - rail_position(frame, straight.data(), samples[i].rail_m);
    data.row(static_cast<Eigen::Index>(i)) << off.dot(axes.direction), off.dot(axes.across),
        off.dot(axes.up);
  }
  return data;
}

RailParameters straight_part(const RailParameters& parameters) {
  RailParameters straight{};
  std::copy_n(parameters.begin(), kRigidParameters, straight.begin());
  return straight;
}

// Adds a fit in the rail's axes to the parameters. Slopes become rotations of the rail, and the
// next round starts from the rotated rail, as its length along the axis is then exact.
void move_rail(const RailFrame& frame, const Eigen::MatrixXd& fit, RailParameters* parameters) {
  RailParameters& p = *parameters;
  const RailAxes<double> axes = rail_axes(frame.axis, p[P::kHeading], p[P::kTilt]);
  const Eigen::Vector3d offset =
      axes.direction * fit(0, 0) + axes.across * fit(0, 1) + axes.up * fit(0, 2);
  for (int i = 0; i < 3; ++i) p[size_t{P::kOffset} + static_cast<size_t>(i)] += offset[i];
  if (fit.rows() > 1) {
    // Heading rotates +z towards +x: a line along x is rotated away from its across axis, +z.
    const double sign = frame.axis == LineAxis::kX ? -1.0 : 1.0;
    p[P::kHeading] += sign * std::atan(fit(1, 1) / frame.half_length_m);
    p[P::kTilt] += std::atan(fit(1, 2) / frame.half_length_m);
  }
  for (size_t i = 0; i < 2; ++i) {
    const auto column = static_cast<Eigen::Index>(i) + 1;
    p[P::kBow + i] = fit.rows() > 2 ? fit(2, column) : 0.0;
    p[P::kSBow + i] = fit.rows() > 3 ? fit(3, column) : 0.0;
  }
}

// Fits the positions with `solve`, which is robust or plain least squares.
template <typename Solve>
void fit_positions(const RailFrame& frame, std::span<const RailSample> samples,
                   Eigen::Index functions, const Solve& solve, RailParameters* parameters) {
  constexpr int kRounds = 4;
  const Eigen::MatrixXd basis = legendre_basis(frame, samples, functions);
  for (int round = 0; round < kRounds; ++round) {
    const RailParameters straight = straight_part(*parameters);
    const Eigen::MatrixXd data = in_rail_axes(frame, straight, samples);
    Eigen::MatrixXd fit = solve(basis, data);
    // Along the rail only the offset is free: the slider's feedback defines lengths there.
    fit.col(0).setZero();
    fit(0, 0) = solve(basis.leftCols(1), data.leftCols(1))(0, 0);
    move_rail(frame, fit, parameters);
  }
}

// The medoid of the samples' rotations, relative to which the others are small.
Eigen::Matrix3d middle_rotation(std::span<const RailSample> samples) {
  size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < samples.size(); ++i) {
    double sum = 0.0;
    for (const RailSample& other : samples) {
      sum += vector_of(samples[i].rotation * other.rotation.transpose()).norm();
    }
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return samples[best].rotation;
}

Eigen::MatrixXd rotation_vectors(std::span<const RailSample> samples,
                                 const Eigen::Matrix3d& middle) {
  Eigen::MatrixXd data(static_cast<Eigen::Index>(samples.size()), 3);
  for (size_t i = 0; i < samples.size(); ++i) {
    data.row(static_cast<Eigen::Index>(i)) =
        vector_of(samples[i].rotation * middle.transpose()).transpose();
  }
  return data;
}

struct Residuals {
  Eigen::MatrixXd position_m;  // along, across, up
  Eigen::MatrixXd rotation_rad;
};

Residuals residuals_of(const RailFrame& frame, const RailParameters& parameters,
                       std::span<const RailSample> samples) {
  const RailAxes<double> axes =
      rail_axes(frame.axis, parameters[P::kHeading], parameters[P::kTilt]);
  const auto count = static_cast<Eigen::Index>(samples.size());
  Residuals residuals{Eigen::MatrixXd(count, 3), Eigen::MatrixXd(count, 3)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const RailSample& sample = samples[static_cast<size_t>(i)];
    const Eigen::Vector3d off =
        sample.position_m - rail_position(frame, parameters.data(), sample.rail_m);
    residuals.position_m.row(i) << off.dot(axes.direction), off.dot(axes.across), off.dot(axes.up);
    const Eigen::Matrix3d expected =
        matrix_of(rail_rotation(frame, parameters.data(), sample.rail_m));
    residuals.rotation_rad.row(i) = vector_of(sample.rotation * expected.transpose()).transpose();
  }
  return residuals;
}

// The scatter in excess of the solved poses' own errors, as a standard deviation.
double jitter_of(const Eigen::MatrixXd& residuals, double sigma, Eigen::Index parameters) {
  if (residuals.rows() <= parameters) return 0.0;
  const Eigen::MatrixXd column = residuals.reshaped(residuals.size(), 1);
  const double freedom =
      static_cast<double>(residuals.rows()) / static_cast<double>(residuals.rows() - parameters);
  const double square = std::pow(residual_sigma(column, 0.0), 2) * freedom - sigma * sigma;
  return std::sqrt(std::max(0.0, square));
}

// Lower bounds of the scatter, to avoid division by zero.
struct LeastScatter {
  double position_m = 0.0;
  double rotation_rad = 1e-7;
};

struct Scatter {
  double along_m = 0.0;
  double across_m = 0.0;
  double rotation_rad = 0.0;
};

// Robust scatter, at least the solved poses' own errors: a line that happens to fit better must not
// make its worst station an outlier.
Scatter scatter_of(const Residuals& residuals, std::span<const RailSample> samples,
                   const LeastScatter& least) {
  std::vector<double> position, rotation;
  for (const RailSample& sample : samples) {
    position.push_back(sample.position_sigma_m);
    rotation.push_back(sample.rotation_sigma_rad);
  }
  const double position_m = std::max(least.position_m, median(std::move(position)));
  const double rotation_rad = std::max(least.rotation_rad, median(std::move(rotation)));
  const Eigen::MatrixXd across = residuals.position_m.rightCols(2).reshaped();
  const Eigen::MatrixXd turned = residuals.rotation_rad.reshaped();
  return {residual_sigma(residuals.position_m.col(0), position_m),
          residual_sigma(across, position_m), residual_sigma(turned, rotation_rad)};
}

std::vector<bool> rejected_samples(const Residuals& residuals, std::span<const RailSample> samples,
                                   const Scatter& scatter, double spacing_m) {
  constexpr double kSigmas = 6.0;
  std::vector<bool> rejected(samples.size(), false);
  // With so few samples an outlier cannot be identified.
  if (samples.size() < 5) return rejected;
  for (size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d off = residuals.position_m.row(static_cast<Eigen::Index>(i));
    const double sigmas = std::max(
        {std::fabs(off.x()) / scatter.along_m, off.tail<2>().norm() / scatter.across_m,
         residuals.rotation_rad.row(static_cast<Eigen::Index>(i)).norm() / scatter.rotation_rad});
    rejected[i] = sigmas > kSigmas && (!samples[i].well_supported || off.norm() > 0.5 * spacing_m);
  }
  return rejected;
}

constexpr std::array kPositionNames{"straight", "bow", "S-bow"};
constexpr std::array kRotationNames{"rigid", "twist", "curved twist"};

// Number of basis functions of the rail position in each model.
struct Functions {
  Eigen::Index position = 1;
  Eigen::Index rotation = 1;
};

// Converts rotation vectors relative to a middle attitude to parameters relative to the plan.
void store_rotation(const Eigen::MatrixXd& vectors, const Eigen::Matrix3d& middle,
                    RailParameters* parameters) {
  const Eigen::Vector3d base = vector_of(matrix_of(vectors.row(0).transpose()) * middle);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto index = static_cast<size_t>(i);
    (*parameters)[P::kRotation + index] = base[i];
    (*parameters)[P::kTwist + index] = vectors.rows() > 1 ? vectors(1, i) : 0.0;
    (*parameters)[P::kCurvedTwist + index] = vectors.rows() > 2 ? vectors(2, i) : 0.0;
  }
}

// `solve` and `solve_turn` fit data (metres, radians) in a basis, robustly or not.
template <typename Solve, typename SolveTurn>
RailParameters fit_with(const RailFrame& frame, std::span<const RailSample> samples,
                        const Functions& functions, const Eigen::Matrix3d& middle,
                        RailParameters start, const Solve& solve, const SolveTurn& solve_turn) {
  fit_positions(frame, samples, functions.position, solve, &start);
  store_rotation(solve_turn(legendre_basis(frame, samples, functions.rotation),
                            rotation_vectors(samples, middle)),
                 middle, &start);
  return start;
}

// Selects among the models that `most` allows; `straight` is an initial straight rail.
Functions choose_models(const RailFrame& frame, std::span<const RailSample> samples,
                        const Functions& most, const Eigen::Matrix3d& middle,
                        const RailParameters& straight, const LeastScatter& least, RailFit* fit) {
  const Eigen::Index line = std::min<Eigen::Index>(most.position, 2);
  const std::array<Eigen::Index, 3> position{line, 3, 4};
  const std::array<Eigen::Index, 3> rotation{1, 2, 3};
  const Eigen::MatrixXd off = in_rail_axes(frame, straight, samples).rightCols(2);
  const int bow =
      choose_model(legendre_basis(frame, samples, most.position), off,
                   std::span(position).first(static_cast<size_t>(most.position - line + 1)),
                   kPositionNames, least.position_m, 1e3, &fit->position_models);
  const int twist =
      choose_model(legendre_basis(frame, samples, most.rotation), rotation_vectors(samples, middle),
                   std::span(rotation).first(static_cast<size_t>(most.rotation)), kRotationNames,
                   least.rotation_rad, degrees_from_radians(1.0), &fit->rotation_models);
  std::fill_n(fit->kept.begin(), kRigidParameters, true);
  std::fill_n(fit->kept.begin() + P::kBow, 2, bow >= 1);
  std::fill_n(fit->kept.begin() + P::kSBow, 2, bow >= 2);
  std::fill_n(fit->kept.begin() + P::kTwist, 3, twist >= 1);
  std::fill_n(fit->kept.begin() + P::kCurvedTwist, 3, twist >= 2);
  return {position[static_cast<size_t>(bow)], rotation[static_cast<size_t>(twist)]};
}

RailJitter jitter_about(const RailFrame& frame, std::span<const RailSample> samples,
                        const RailParameters& parameters, const Functions& functions) {
  double position_square = 0.0;
  double rotation_square = 0.0;
  for (const RailSample& sample : samples) {
    position_square += std::pow(sample.position_sigma_m, 2);
    rotation_square += std::pow(sample.rotation_sigma_rad, 2);
  }
  const auto count = static_cast<double>(samples.size());
  const double position_m = std::sqrt(position_square / count);
  const Residuals rest = residuals_of(frame, parameters, samples);
  return {jitter_of(rest.position_m.leftCols(1), position_m, 1),
          jitter_of(rest.position_m.rightCols(2), position_m, functions.position),
          jitter_of(rest.rotation_rad, std::sqrt(rotation_square / count), functions.rotation)};
}

}  // namespace

RailFit fit_rail(const RailFrame& frame, std::span<const RailSample> samples, double spacing_m) {
  const LeastScatter least{1e-7 * spacing_m, 1e-7};
  const Functions most{functions_for(samples.size(), 4), functions_for(samples.size(), 3)};
  const Eigen::Matrix3d middle = middle_rotation(samples);
  const auto robust = [](double least_scatter) {
    return [least_scatter](const Eigen::MatrixXd& basis, const Eigen::MatrixXd& data) {
      return robust_fit(basis, data, least_scatter);
    };
  };
  const RailParameters richest = fit_with(frame, samples, most, middle, {},
                                          robust(least.position_m), robust(least.rotation_rad));
  const Residuals rich = residuals_of(frame, richest, samples);
  RailFit fit;
  fit.rejected = rejected_samples(rich, samples, scatter_of(rich, samples, least), spacing_m);
  std::vector<RailSample> used;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!fit.rejected[i]) used.push_back(samples[i]);
  }
  const RailParameters straight = straight_part(richest);
  const Functions kept = choose_models(frame, used, most, middle, straight, least, &fit);
  fit.parameters = fit_with(frame, used, kept, middle, straight, least_squares, least_squares);
  fit.jitter = jitter_about(frame, used, fit.parameters, kept);
  return fit;
}

}  // namespace raywalk::calibrate
