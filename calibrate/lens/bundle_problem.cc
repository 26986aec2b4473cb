#include "calibrate/lens/bundle_problem.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/lens/camera_model.h"

namespace raywalk::calibrate {
namespace {

constexpr int kPointParameters = 3;

// Prior deviations from the plan. A rail laid by hand lies within some centimetres and degrees. On
// it the camera follows the drive's position, except for play and the bow of the rail.
constexpr double kLineTurn_rad = radians_from_degrees(5.0);
constexpr double kLineShift_m = 0.05;
constexpr double kStationTurn_rad = radians_from_degrees(5.0);
constexpr double kStationShift_m = 0.0015;
// Prior deviations of the back lens's pose from a maker's drawing or a starting file.
constexpr double kBackTurn_rad = radians_from_degrees(5.0);
constexpr double kBaseline_m = 0.01;

struct ObservationResidual {
  CameraFrame frame{};
  bool back = false;
  Eigen::Vector3d nominal_m{};  // of the station
  Eigen::Matrix3d camera_from_world{};
  Eigen::Vector3d line_middle_m{};
  TrackPoint point{};
  PixelPosition seen{};
  double sigma_px = 1.0;

  template <typename T>
  bool operator()(const T* lens, const T* back_pose, const T* line, const T* station,
                  const T* value, T* residual) const {
    T from_middle[3], turned[3], ray[3], in_nominal[3], in_camera[3], pixel[2];
    for (int i = 0; i < 3; ++i) from_middle[i] = T(nominal_m[i] - line_middle_m[i]);
    ceres::AngleAxisRotatePoint(line, from_middle, turned);
    for (int i = 0; i < 3; ++i) {
      const T position_m = line_middle_m[i] + turned[i] + line[3 + i] + station[3 + i];
      ray[i] = point.axis[i] + value[0] * point.right[i] + value[1] * point.up[i] -
               value[2] * (position_m - point.from_m[i]);
    }
    for (int i = 0; i < 3; ++i) {
      in_nominal[i] = camera_from_world(i, 0) * ray[0] + camera_from_world(i, 1) * ray[1] +
                      camera_from_world(i, 2) * ray[2];
    }
    ceres::AngleAxisRotatePoint(station, in_nominal, in_camera);
    image_point(frame, back, lens, back_pose, in_camera, value[2], pixel);
    residual[0] = (seen.u - pixel[0]) / sigma_px;
    residual[1] = (seen.v - pixel[1]) / sigma_px;
    return true;
  }
};

ObservationResidual residual_term(const BundleInput& input, const CameraFrame& frame,
                                  const Eigen::Vector3d& line_middle_m, const TrackPoint& point,
                                  const BundleObservation& observation, double sigma_px) {
  const BundleStation& station = input.stations[observation.station];
  return {frame,
          observation.back,
          station.nominal_m,
          station.nominal_world_from_camera.transpose(),
          line_middle_m,
          point,
          observation.seen,
          sigma_px};
}

// Deviations of parameters from their prior mean, in units of its standard deviations.
template <std::size_t kCount>
struct Prior {
  std::array<double, kCount> mean{};
  std::array<double, kCount> sigma{};

  template <typename T>
  bool operator()(const T* parameters, T* residual) const {
    for (std::size_t i = 0; i < kCount; ++i) residual[i] = (parameters[i] - mean[i]) / sigma[i];
    return true;
  }
};

template <std::size_t kCount>
void add_prior(const Prior<kCount>& prior, std::array<double, kCount>* parameters,
               ceres::Problem* problem) {
  using Cost = ceres::AutoDiffCostFunction<Prior<kCount>, kCount, kCount>;
  problem->AddResidualBlock(new Cost(new Prior<kCount>(prior)), nullptr, parameters->data());
}

PoseParameters pose_sigma(double turn_rad, double shift_m) {
  return {turn_rad, turn_rad, turn_rad, shift_m, shift_m, shift_m};
}

// Keep the lens near the start where the pictures do not determine it. Typical deviations from a
// maker's figures are at most a tenth of the radius in the centre, a fifth in the focal length, and
// a third of the radius at the rim in each term of the polynomial.
LensParameters lens_sigma(const FisheyeLens& start) {
  const double rim = fisheye_radius(start.k, start.largest_angle_rad);
  LensParameters sigma{};
  sigma[0] = sigma[1] = 0.1 * rim * start.focal_px;
  sigma[2] = 0.2 * start.focal_px;
  double power = start.largest_angle_rad;
  for (std::size_t i = 3; i < sigma.size(); ++i) {
    power *= start.largest_angle_rad * start.largest_angle_rad;
    sigma[i] = rim / (3.0 * power);
  }
  return sigma;
}

void add_priors(const BundleInput& input, BundleState* state, ceres::Problem* problem) {
  const CameraParameters start = parameters_of(input.start);
  CameraParameters& camera = state->camera;
  add_prior({start.front, lens_sigma(input.start.front)}, &camera.front, problem);
  add_prior({start.back, lens_sigma(input.start.back)}, &camera.back, problem);
  add_prior({start.back_pose, pose_sigma(kBackTurn_rad, kBaseline_m)}, &camera.back_pose, problem);
  for (PoseParameters& line : state->lines) {
    add_prior({{}, pose_sigma(kLineTurn_rad, kLineShift_m)}, &line, problem);
  }
  for (PoseParameters& station : state->stations) {
    add_prior({{}, pose_sigma(kStationTurn_rad, kStationShift_m)}, &station, problem);
  }
}

// An anchor on the ray, with two directions at right angles to it.
TrackPoint anchored_at(const ViewRay& ray) {
  TrackPoint point;
  point.from_m = ray.origin_m;
  point.axis = ray.direction;
  Eigen::Index least = 0;
  ray.direction.cwiseAbs().minCoeff(&least);
  point.right = ray.direction.cross(Eigen::Vector3d::Unit(least)).normalized();
  point.up = ray.direction.cross(point.right);
  return point;
}

}  // namespace

// The cross product of an observed unit direction with the predicted ray is the sine of their angle
// (the predicted ray is near unit length) and linear in the three unknowns.
std::optional<TrackPoint> triangulate(std::span<const ViewRay> rays) {
  TrackPoint point = anchored_at(rays.front());
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const ViewRay& ray : rays) {
    Eigen::Matrix3d slope;
    slope.col(0) = ray.direction.cross(point.right);
    slope.col(1) = ray.direction.cross(point.up);
    slope.col(2) = ray.direction.cross(point.from_m - ray.origin_m);
    normal += slope.transpose() * slope;
    right_side -= slope.transpose() * ray.direction.cross(point.axis);
  }
  // Parallel rays, or rays of one origin, do not determine the distance. A small prior then puts
  // the point at infinity; it is negligible for a parallax of some millimetres.
  constexpr double kPrior_m2 = 1e-8;
  normal(2, 2) += kPrior_m2;
  const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
  point.value = factors.solve(right_side);
  if (factors.info() != Eigen::Success || !point.value.allFinite()) return std::nullopt;
  for (const ViewRay& ray : rays) {
    if (point.ray_from(ray.origin_m).dot(ray.direction) <= 0.0) return std::nullopt;
  }
  return point;
}

std::vector<Eigen::Vector3d> line_middles(const BundleInput& input) {
  std::vector<Eigen::Vector3d> sum(input.lines, Eigen::Vector3d::Zero());
  std::vector<int> count(input.lines, 0);
  for (const BundleStation& station : input.stations) {
    sum[station.line] += station.nominal_m;
    ++count[station.line];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] /= std::max(count[i], 1);
  return sum;
}

Eigen::Vector2d residual_of(const BundleInput& input, const BundleState& state,
                            const Eigen::Vector3d& line_middle_m, const TrackPoint& point,
                            const BundleObservation& observation) {
  const std::size_t line = input.stations[observation.station].line;
  const CameraParameters& camera = state.camera;
  Eigen::Vector2d residual;
  residual_term(input, camera_frame_of(input.start), line_middle_m, point, observation, 1.0)(
      (observation.back ? camera.back : camera.front).data(), camera.back_pose.data(),
      state.lines[line].data(), state.stations[observation.station].data(), point.value.data(),
      residual.data());
  return residual;
}

void build_problem(const BundleInput& input, double sigma_px, BundleState* state,
                   std::vector<ActiveTrack>* tracks, ceres::Problem* problem) {
  using Cost = ceres::AutoDiffCostFunction<ObservationResidual, 2, kLensParameters, kPoseParameters,
                                           kPoseParameters, kPoseParameters, kPointParameters>;
  const CameraFrame frame = camera_frame_of(input.start);
  const std::vector<Eigen::Vector3d> middles = line_middles(input);
  CameraParameters& camera = state->camera;
  for (ActiveTrack& active : *tracks) {
    for (const BundleObservation& seen : active.seen) {
      const std::size_t line = input.stations[seen.station].line;
      problem->AddResidualBlock(new Cost(new ObservationResidual(residual_term(
                                    input, frame, middles[line], active.point, seen, sigma_px))),
                                new ceres::CauchyLoss(kCauchySigmas),
                                (seen.back ? camera.back : camera.front).data(),
                                camera.back_pose.data(), state->lines[line].data(),
                                state->stations[seen.station].data(), active.point.value.data());
    }
  }
  add_priors(input, state, problem);
}

}  // namespace raywalk::calibrate
