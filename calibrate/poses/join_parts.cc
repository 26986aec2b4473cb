#include "calibrate/poses/join_parts.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <tuple>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/base/disjoint_sets.h"
#include "calibrate/base/rotation.h"
#include "calibrate/base/stop_on_interrupt.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// Observations in the adjustment of all poses, which takes about 600 bytes for each. In a grid of
// few parts every panorama keeps as many as in the last adjustment of a part.
constexpr double kObservationsOfAll = 8e6;
constexpr int kLeastPointsPerFrame = 100;
constexpr int kMostPointsPerFrame = 1500;
// Parts that share fewer posed frames are not connected.
constexpr int kLeastShared = 3;
// Lower bounds of the sigmas of a pose in a part.
constexpr double kLeastSigma_mm = 1e-2;
constexpr double kLeastSigma_deg = 1e-3;
// Of the scales of parts, relative: what the slider leaves open.
constexpr double kScaleSigma = 1e-3;
// The first without a loss, as the parts are far beyond their sigmas.
constexpr int kJoinPasses = 4;
// The median length of a vector of six independent normal variables.
constexpr double kMedianOfSix = 2.3126;

// Rotation vector, translation in metres, logarithm of the scale.
using SimilarityParameters = std::array<double, 7>;

// A frame that two parts have in common.
struct SharedFrame {
  std::size_t a = 0;  // the parts
  std::size_t b = 0;
  const FramePose* in_a = nullptr;
  const FramePose* in_b = nullptr;
};

std::vector<SharedFrame> shared_frames(std::span<const FramePoses> parts) {
  std::size_t frames = 0;
  for (const FramePoses& poses : parts) frames = std::max(frames, poses.size());
  std::vector<SharedFrame> shared;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    std::vector<std::size_t> posed;
    for (std::size_t part = 0; part < parts.size(); ++part) {
      if (frame < parts[part].size() && parts[part][frame]) posed.push_back(part);
    }
    for (std::size_t i = 0; i < posed.size(); ++i) {
      for (std::size_t k = i + 1; k < posed.size(); ++k) {
        shared.push_back({posed[i], posed[k], &*parts[posed[i]][frame], &*parts[posed[k]][frame]});
      }
    }
  }
  return shared;
}

// The differences of a frame's position and rotation in two parts, in their sigmas.
class SharedFrameResidual {
 public:
  explicit SharedFrameResidual(const SharedFrame& frame)
      : a_(*frame.in_a),
        b_(*frame.in_b),
        position_sigma_m_(1e-3 * std::hypot(std::max(kLeastSigma_mm, a_.position_sigma_mm),
                                            std::max(kLeastSigma_mm, b_.position_sigma_mm))),
        rotation_sigma_rad_(
            radians_from_degrees(std::hypot(std::max(kLeastSigma_deg, a_.rotation_sigma_deg),
                                            std::max(kLeastSigma_deg, b_.rotation_sigma_deg)))) {}

  template <typename T>
  bool operator()(const T* of_a, const T* of_b, T* residual) const {
    const Eigen::Matrix<T, 3, 3> turned_a = rotation(of_a) * a_.world_from_camera.cast<T>();
    const Eigen::Matrix<T, 3, 3> turned_b = rotation(of_b) * b_.world_from_camera.cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(residual);
    out.template head<3>() =
        (moved(of_b, b_.position_m) - moved(of_a, a_.position_m)) / T(position_sigma_m_);
    // The sine of the angle between them, along its axis.
    const Eigen::Matrix<T, 3, 3> turn = turned_a.transpose() * turned_b;
    const T half(0.5);
    out[3] = half * (turn(2, 1) - turn(1, 2)) / T(rotation_sigma_rad_);
    out[4] = half * (turn(0, 2) - turn(2, 0)) / T(rotation_sigma_rad_);
    out[5] = half * (turn(1, 0) - turn(0, 1)) / T(rotation_sigma_rad_);
    return true;
  }

 private:
  template <typename T>
  static Eigen::Matrix<T, 3, 3> rotation(const T* similarity) {
    Eigen::Matrix<T, 3, 3> matrix;
    ceres::AngleAxisToRotationMatrix(similarity, matrix.data());
    return matrix;
  }
  template <typename T>
  static Eigen::Matrix<T, 3, 1> moved(const T* similarity, const Eigen::Vector3d& position_m) {
    using std::exp;
    const Eigen::Matrix<T, 3, 1> translation_m(similarity[3], similarity[4], similarity[5]);
    return exp(similarity[6]) * (rotation(similarity) * position_m.cast<T>()) + translation_m;
  }

  const FramePose& a_;
  const FramePose& b_;
  double position_sigma_m_;
  double rotation_sigma_rad_;
};

using SharedFrameCost = ceres::AutoDiffCostFunction<SharedFrameResidual, 6, 7, 7>;

struct ScaleResidual {
  template <typename T>
  bool operator()(const T* similarity, T* residual) const {
    residual[0] = similarity[6] / kScaleSigma;
    return true;
  }
};

// The spread of the residuals, in the sigmas; at least 1.
double spread_of(const std::vector<SharedFrame>& shared,
                 const std::vector<SimilarityParameters>& parameters) {
  std::vector<double> lengths;
  for (const SharedFrame& frame : shared) {
    std::array<double, 6> residual{};
    const SharedFrameResidual of_frame(frame);
    of_frame(parameters[frame.a].data(), parameters[frame.b].data(), residual.data());
    lengths.push_back(
        std::sqrt(std::inner_product(residual.begin(), residual.end(), residual.begin(), 0.0)));
  }
  return std::max(1.0, median(std::move(lengths)) / kMedianOfSix);
}

// `loss_width` 0: least squares.
void solve_pass(const std::vector<SharedFrame>& shared, std::size_t fixed, double loss_width,
                std::vector<SimilarityParameters>* parameters) {
  ceres::Problem problem;
  ceres::LossFunction* loss = nullptr;
  if (loss_width > 0.0) loss = std::make_unique<ceres::CauchyLoss>(loss_width).release();
  for (const SharedFrame& frame : shared) {
    auto cost =
        std::make_unique<SharedFrameCost>(std::make_unique<SharedFrameResidual>(frame).release());
    problem.AddResidualBlock(cost.release(), loss, (*parameters)[frame.a].data(),
                             (*parameters)[frame.b].data());
  }
  using ScaleCost = ceres::AutoDiffCostFunction<ScaleResidual, 1, 7>;
  for (SimilarityParameters& similarity : *parameters) {
    auto cost = std::make_unique<ScaleCost>(std::make_unique<ScaleResidual>().release());
    problem.AddResidualBlock(cost.release(), nullptr, similarity.data());
  }
  problem.SetParameterBlockConstant((*parameters)[fixed].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  StopOnInterrupt stop;
  options.callbacks = {&stop};
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  throw_if_interrupted();
}

PoseAlignment alignment_of(const SimilarityParameters& similarity) {
  PoseAlignment alignment;
  alignment.scale = std::exp(similarity[6]);
  alignment.rotation = matrix_of({similarity[0], similarity[1], similarity[2]});
  alignment.translation_m = {similarity[3], similarity[4], similarity[5]};
  return alignment;
}

void move_points(const PoseAlignment& by, SeenPoints* points) {
  for (Eigen::Vector3d& point : points->points_m) {
    point = by.scale * by.rotation * point + by.translation_m;
  }
}

// Without the points whose observations `keeps` none of, or not enough of them.
template <typename Keeps>
SeenPoints filtered(const SeenPoints& points, const Keeps& keeps) {
  SeenPoints kept;
  kept.points_m = points.points_m;
  std::copy_if(points.observations.begin(), points.observations.end(),
               std::back_inserter(kept.observations), keeps);
  return widely_seen(kept, 2);
}

std::size_t posed_count(const FramePoses& poses) {
  return static_cast<std::size_t>(
      std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return bool(pose); }));
}

// Whether each part is connected with the part `main` by shared frames.
std::vector<bool> connected_parts(const std::vector<SharedFrame>& shared, std::size_t parts,
                                  std::size_t main) {
  std::vector<int> counts(parts * parts, 0);
  for (const SharedFrame& frame : shared) ++counts[frame.a * parts + frame.b];
  DisjointSets sets(static_cast<int>(parts));
  for (std::size_t a = 0; a < parts; ++a) {
    for (std::size_t b = 0; b < parts; ++b) {
      if (counts[a * parts + b] < kLeastShared) continue;
      sets.join(static_cast<int>(a), static_cast<int>(b));
    }
  }
  std::vector<bool> connected(parts, false);
  for (std::size_t part = 0; part < parts; ++part) {
    connected[part] = sets.root(static_cast<int>(part)) == sets.root(static_cast<int>(main));
  }
  return connected;
}

void add_points(const SeenPoints& points, const FramePoses& poses, SeenPoints* all) {
  const int offset = static_cast<int>(all->points_m.size());
  all->points_m.insert(all->points_m.end(), points.points_m.begin(), points.points_m.end());
  for (PointObservation observation : points.observations) {
    if (!poses[static_cast<std::size_t>(observation.frame)]) continue;
    observation.point += offset;
    all->observations.push_back(observation);
  }
}

// Whether two observations are of the same feature: parts find the same ones in a frame.
auto feature_of(const PointObservation& observation) {
  const Eigen::Vector3d& bearing = observation.bearing;
  return std::tuple(observation.frame, bearing.x(), bearing.y(), bearing.z());
}

// Points of which parts saw the same feature are one, at the place of the first; every feature
// counts once.
SeenPoints united(const SeenPoints& points) {
  std::vector<std::size_t> order(points.observations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return feature_of(points.observations[a]) < feature_of(points.observations[b]);
  });
  DisjointSets sets(static_cast<int>(points.points_m.size()));
  std::vector<bool> again(order.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i) {
    const PointObservation& last = points.observations[order[i - 1]];
    const PointObservation& next = points.observations[order[i]];
    if (feature_of(last) != feature_of(next)) continue;
    sets.join(next.point, last.point);
    again[order[i]] = true;
  }
  // The first point of every set, by the set's root.
  std::vector<int> first(points.points_m.size(), -1);
  for (int point = 0; point < static_cast<int>(first.size()); ++point) {
    int& of_set = first[static_cast<std::size_t>(sets.root(point))];
    if (of_set < 0) of_set = point;
  }
  SeenPoints one;
  one.points_m = points.points_m;
  for (std::size_t i = 0; i < again.size(); ++i) {
    if (again[i]) continue;
    PointObservation observation = points.observations[i];
    observation.point = first[static_cast<std::size_t>(sets.root(observation.point))];
    one.observations.push_back(observation);
  }
  return widely_seen(one, 2);
}

}  // namespace

void thin_for_joining(const PoseProblem& problem, const PosePart& part, RefinedPoses* refined) {
  const PoseAlignment alignment = align_poses(problem.set, refined->poses, problem.nominal);
  refined->poses = aligned(refined->poses, alignment);
  move_points(alignment, &refined->points);

  std::vector<int> first(refined->points.points_m.size(), std::numeric_limits<int>::max());
  for (const PointObservation& observation : refined->points.observations) {
    int& of_point = first[static_cast<std::size_t>(observation.point)];
    of_point = std::min(of_point, observation.frame);
  }
  const SeenPoints own = filtered(refined->points, [&](const PointObservation& observation) {
    return std::binary_search(part.home.begin(), part.home.end(),
                              first[static_cast<std::size_t>(observation.point)]);
  });
  const double wanted = kObservationsOfAll / static_cast<double>(problem.keyframes.size());
  refined->points = strongest(
      own, std::clamp(static_cast<int>(wanted), kLeastPointsPerFrame, kMostPointsPerFrame));
  // Of other observations than are left.
  refined->errors_px.assign(refined->points.observations.size(), 0.0);
}

std::vector<PoseAlignment> similarities(std::span<const FramePoses> parts, std::size_t fixed) {
  const std::vector<SharedFrame> shared = shared_frames(parts);
  std::vector<SimilarityParameters> parameters(parts.size(), SimilarityParameters{});
  for (int pass = 0; pass < kJoinPasses && !shared.empty(); ++pass) {
    solve_pass(shared, fixed, pass == 0 ? 0.0 : kCauchySigmas * spread_of(shared, parameters),
               &parameters);
  }
  std::vector<PoseAlignment> found;
  found.reserve(parameters.size());
  for (const SimilarityParameters& similarity : parameters) {
    found.push_back(alignment_of(similarity));
  }
  return found;
}

JoinedParts join_parts(const PoseProblem& problem, std::span<const PartSolution> solutions) {
  std::vector<FramePoses> parts;
  for (const PartSolution& solution : solutions) {
    parts.push_back(solution.solved() ? solution.refined.poses : FramePoses());
  }
  const auto main =
      static_cast<std::size_t>(std::max_element(parts.begin(), parts.end(),
                                                [](const FramePoses& a, const FramePoses& b) {
                                                  return posed_count(a) < posed_count(b);
                                                }) -
                               parts.begin());
  const std::vector<PoseAlignment> moves = similarities(parts, main);
  const std::vector<bool> connected = connected_parts(shared_frames(parts), parts.size(), main);
  JoinedParts joined{.poses = FramePoses(problem.set.frames.size())};
  // A frame's pose is that of its home, else of the first part that has one.
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (!connected[part] || parts[part].empty()) continue;
    parts[part] = aligned(parts[part], moves[part]);
    for (const int frame : problem.parts[part].home) {
      const auto index = static_cast<std::size_t>(frame);
      joined.poses[index] = parts[part][index];
    }
  }
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (!connected[part] || parts[part].empty()) continue;
    for (std::size_t i = 0; i < joined.poses.size(); ++i) {
      if (!joined.poses[i]) joined.poses[i] = parts[part][i];
    }
  }
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (!connected[part] || parts[part].empty()) continue;
    SeenPoints points = solutions[part].refined.points;
    move_points(moves[part], &points);
    add_points(points, joined.poses, &joined.points);
  }
  joined.points = united(joined.points);
  if (joined.points.observations.empty()) return joined;
  const PoseAlignment alignment = align_poses(problem.set, joined.poses, problem.nominal);
  joined.poses = aligned(joined.poses, alignment);
  move_points(alignment, &joined.points);
  return joined;
}

}  // namespace raywalk::calibrate
