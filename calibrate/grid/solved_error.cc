#include "calibrate/grid/solved_error.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

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

}  // namespace

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
