#include "calibrate/grid/prepared_rails.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// Number of samples from which a line's own scatter is used.
constexpr size_t kSamplesForJitter = 8;

// Lower bounds of the scatter: smaller ones make the problem ill-conditioned.
RailJitter with_lower_bounds(const RailJitter& jitter, const GridScale& scale) {
  constexpr double kLeastRotation_rad = 1e-5;
  const double least_m = 1e-4 * scale.spacing_m;
  return {std::max(jitter.along_m, least_m), std::max(jitter.across_m, least_m),
          std::max(jitter.rotation_rad, kLeastRotation_rad)};
}

void set_sigmas(const GridScale& scale, FramePose* pose) {
  if (!(pose->position_sigma_mm > 0.0)) pose->position_sigma_mm = 1e3 * scale.spacing_m / 200.0;
  if (!(pose->rotation_sigma_deg > 0.0)) {
    pose->rotation_sigma_deg = degrees_from_radians(0.1 * scale.pixel_rad);
  }
}

// Medians over all solved poses, to find poorly supported ones.
struct Support {
  double observations = 0.0;
  double residual_px = 0.0;

  bool good(const FramePose& pose) const {
    return observations > 0.0 && 2.0 * pose.observations >= observations &&
           pose.residual_px <= 2.0 * residual_px;
  }
};

Support support_of(const FramePoses& poses) {
  std::vector<double> observations;
  std::vector<double> residuals;
  for (const std::optional<FramePose>& pose : poses) {
    if (!pose) continue;
    observations.push_back(pose->observations);
    residuals.push_back(pose->residual_px);
  }
  if (observations.empty()) return {};
  return {median(std::move(observations)), median(std::move(residuals))};
}

std::vector<RailSample> samples_of(const CaptureSet& set, const CaptureLine& line,
                                   const FramePoses& solved, const Support& support) {
  std::vector<RailSample> samples;
  for (const int index : line.frames) {
    const std::optional<FramePose>& pose = solved[static_cast<size_t>(index)];
    if (!pose) continue;
    const CaptureFrame& frame = set.frames[static_cast<size_t>(index)];
    samples.push_back({.frame = index,
                       .rail_m = set.rail_m(index),
                       .position_m = pose->position_m,
                       .rotation = pose->world_from_camera * planned_attitude(frame).transpose(),
                       .position_sigma_m = 1e-3 * pose->position_sigma_mm,
                       .rotation_sigma_rad = radians_from_degrees(pose->rotation_sigma_deg),
                       .well_supported = support.good(*pose)});
  }
  return samples;
}

// Median of the lines that measure their own scatter, component by component.
RailJitter pooled_jitter(const PreparedRails& prepared, const GridScale& scale) {
  std::vector<double> along, across, rotation;
  for (size_t line = 0; line < prepared.fits.size(); ++line) {
    if (!prepared.fits[line] || prepared.samples[line].size() < kSamplesForJitter) continue;
    const RailJitter& jitter = prepared.fits[line]->jitter;
    along.push_back(jitter.along_m);
    across.push_back(jitter.across_m);
    rotation.push_back(jitter.rotation_rad);
  }
  // Else 1/25 of the stations' spacing (1 mm of 25 mm) and a tenth of a degree: a rail is built to
  // run straight.
  if (along.empty()) {
    return {scale.spacing_m / 25.0, scale.spacing_m / 25.0, radians_from_degrees(0.1)};
  }
  return {median(std::move(along)), median(std::move(across)), median(std::move(rotation))};
}

void fit_line_of(PreparedRails* prepared, size_t line, const GridScale& scale) {
  std::vector<RailSample>& samples = prepared->samples[line];
  RailStart& rail = prepared->rails[line];
  if (samples.empty()) return;
  RailFit fit = fit_rail(rail.frame, samples, scale.spacing_m);
  std::vector<RailSample> good;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!fit.rejected[i]) {
      good.push_back(samples[i]);
      continue;
    }
    prepared->rejected[line].push_back(samples[i].frame);
    prepared->solved[static_cast<size_t>(samples[i].frame)].reset();
  }
  samples = std::move(good);
  rail.parameters = fit.parameters;
  rail.kept = fit.kept;
  prepared->fits[line] = std::move(fit);
}

// Collects differences over all crossings, of positions or of rotations.
class ExcessVariance {
 public:
  void add(const Eigen::Vector3d& difference, const Eigen::Matrix3d& covariance) {
    const Eigen::Matrix3d information = covariance.inverse();
    square_ += difference.dot(information * difference);
    information_ += information.trace();
    components_ += 3.0;
  }

  // Excess sigma of one line. A difference has the excess of two lines, so the expected sum of
  // squares is the number of components plus twice the excess variance times the information.
  double sigma() const {
    if (!(information_ > 0.0)) return 0.0;
    return std::sqrt(std::max(0.0, (square_ - components_) / (2.0 * information_)));
  }

 private:
  double square_ = 0.0;
  double information_ = 0.0;
  double components_ = 0.0;
};

// Variances of each component of a difference from both lines' own errors.
struct OwnVariance {
  double position = 0.0;
  double rotation = 0.0;
};

OwnVariance own_variance(const PreparedRails& prepared, const LineCrossing& crossing) {
  OwnVariance sum;
  for (const int line : {crossing.along_x, crossing.along_z}) {
    std::vector<double> position;
    std::vector<double> rotation;
    for (const RailSample& sample : prepared.samples[static_cast<size_t>(line)]) {
      position.push_back(sample.position_sigma_m);
      rotation.push_back(sample.rotation_sigma_rad);
    }
    sum.position += std::pow(median(std::move(position)), 2);
    sum.rotation += std::pow(median(std::move(rotation)), 2);
  }
  return sum;
}

bool has_samples(const PreparedRails& prepared, int line) {
  return !prepared.samples[static_cast<size_t>(line)].empty();
}

std::vector<LineMotion> motions_of_start(const CaptureSet& set, const FramePoses& start) {
  std::vector<LineMotion> motions(set.lines.size());
  for (size_t line = 0; line < set.lines.size(); ++line) {
    for (const int index : set.lines[line].frames) {
      const CaptureFrame& frame = set.frames[static_cast<size_t>(index)];
      const FramePose& pose = *start[static_cast<size_t>(index)];
      motions[line].rotation_rad +=
          vector_of(pose.world_from_camera * planned_attitude(frame).transpose());
      motions[line].offset_m += pose.position_m - frame.nominal_m;
    }
    const auto count = static_cast<double>(set.lines[line].frames.size());
    motions[line].rotation_rad /= count;
    motions[line].offset_m /= count;
  }
  return motions;
}

}  // namespace

PreparedRails prepare_rails(const CaptureSet& set, const FramePoses& solved,
                            const FramePoses& start, const GridScale& scale) {
  PreparedRails prepared{.solved = solved};
  for (std::optional<FramePose>& pose : prepared.solved) {
    if (pose) set_sigmas(scale, &*pose);
  }
  const Support support = support_of(prepared.solved);
  const std::vector<LineMotion> motions = motions_of_start(set, start);
  const size_t lines = set.lines.size();
  prepared.fits.resize(lines);
  prepared.rejected.resize(lines);
  for (size_t line = 0; line < lines; ++line) {
    RailStart rail{.frame = rail_frame(set, static_cast<int>(line))};
    std::fill_n(rail.kept.begin(), kRigidParameters, true);
    for (size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      rail.parameters[P::kOffset + i] = motions[line].offset_m[axis];
      rail.parameters[P::kRotation + i] = motions[line].rotation_rad[axis];
    }
    rail.offset_prior_m = fit_scale(scale).motion_m;
    prepared.rails.push_back(rail);
    prepared.samples.push_back(samples_of(set, set.lines[line], prepared.solved, support));
    fit_line_of(&prepared, line, scale);
  }
  const RailJitter pooled = pooled_jitter(prepared, scale);
  for (size_t line = 0; line < lines; ++line) {
    const bool own = prepared.samples[line].size() >= kSamplesForJitter;
    prepared.rails[line].jitter =
        with_lower_bounds(own ? prepared.fits[line]->jitter : pooled, scale);
  }
  return prepared;
}

FramePoses poses_on_rails(const CaptureSet& set, const std::vector<RailStart>& rails,
                          const FramePoses& solved) {
  FramePoses poses = solved;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) continue;
    const RailStart& rail = rails[static_cast<size_t>(set.frames[i].line)];
    const double rail_m = set.rail_m(static_cast<int>(i));
    poses[i] = FramePose{
        .position_m = rail_position(rail.frame, rail.parameters.data(), rail_m),
        .world_from_camera = matrix_of(rail_rotation(rail.frame, rail.parameters.data(), rail_m)) *
                             planned_attitude(set.frames[i]),
        .origin = PoseOrigin::kRail};
  }
  return poses;
}

void align_at_crossings(std::span<const FittedCrossing> crossings,
                        const std::vector<bool>& may_move, std::vector<LineMotion>* lines) {
  const auto count = static_cast<Eigen::Index>(crossings.size());
  if (count == 0) return;
  Eigen::MatrixXd differences =
      Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(lines->size()));
  Eigen::MatrixXd offsets(count, 6);
  for (Eigen::Index i = 0; i < count; ++i) {
    const FittedCrossing& crossing = crossings[static_cast<size_t>(i)];
    const int x = crossing.crossing.along_x;
    const int z = crossing.crossing.along_z;
    // A fixed line has a zero column, so its minimum-norm motion is zero.
    differences(i, x) = may_move[static_cast<size_t>(x)] ? 1.0 : 0.0;
    differences(i, z) = may_move[static_cast<size_t>(z)] ? -1.0 : 0.0;
    offsets.row(i) << crossing.fit.rotation_rad.transpose(), crossing.fit.motion_m.transpose();
  }
  const Eigen::MatrixXd motions = differences.completeOrthogonalDecomposition().solve(offsets);
  for (size_t line = 0; line < lines->size(); ++line) {
    const Eigen::RowVectorXd motion = motions.row(static_cast<Eigen::Index>(line));
    (*lines)[line].rotation_rad =
        vector_of(matrix_of(motion.head<3>()) * matrix_of((*lines)[line].rotation_rad));
    (*lines)[line].offset_m += motion.tail<3>();
  }
}

SolvedLineError common_error(std::span<const FittedCrossing> fitted,
                             const PreparedRails& prepared) {
  ExcessVariance position;
  ExcessVariance rotation;
  for (const FittedCrossing& one : fitted) {
    if (!has_samples(prepared, one.crossing.along_x) ||
        !has_samples(prepared, one.crossing.along_z)) {
      continue;
    }
    const OwnVariance own = own_variance(prepared, one.crossing);
    const PoseCovariance& covariance = one.fit.covariance;
    position.add(one.fit.motion_m,
                 covariance.topLeftCorner<3, 3>() + own.position * Eigen::Matrix3d::Identity());
    rotation.add(one.fit.rotation_rad,
                 covariance.bottomRightCorner<3, 3>() + own.rotation * Eigen::Matrix3d::Identity());
  }
  return {position.sigma(), rotation.sigma()};
}

}  // namespace raywalk::calibrate
