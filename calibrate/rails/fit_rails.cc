#include "calibrate/rails/fit_rails.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/rails/rail_cost.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// With fewer stations a line's own scatter is too uncertain to be believed where it is small.
constexpr int kStationsForScatter = 8;
// Of placing a rail and a camera by hand, far beyond the errors of either: they only fix what
// nothing else determines.
constexpr double kPlacing_rad = 0.2;
constexpr int kRounds = 6;

std::vector<std::size_t> posed_stations(const CaptureLine& line, const FramePoses& poses) {
  std::vector<std::size_t> posed;
  std::copy_if(line.frames.begin(), line.frames.end(), std::back_inserter(posed),
               [&](std::size_t frame) { return poses[frame].has_value(); });
  return posed;
}

// The number of functions of the rail position (1, u, P2, P3) that `stations` determine with
// something left to measure their scatter by.
std::size_t functions_for(std::size_t stations) {
  return stations < 3 ? 1 : std::max<std::size_t>(2, (stations - 2) / 2);
}

void keep_supported(std::size_t stations, Rail* rail) {
  const std::size_t functions = functions_for(stations);
  const auto keep = [&](int first, int count, bool kept) {
    std::fill_n(rail->kept.begin() + first, count, kept);
  };
  keep(P::kOffset, 3, true);
  keep(P::kHeading, 2, functions >= 2);
  keep(P::kRotation, 3, true);
  keep(P::kBow, 2, functions >= 3);
  keep(P::kSBow, 2, functions >= 4);
  keep(P::kTwist, 3, functions >= 2);
  keep(P::kCurvedTwist, 3, functions >= 3);
}

// Smaller scatter makes the problem ill-conditioned.
RailScatter with_least(const RailScatter& scatter, double spacing_m) {
  constexpr double kLeastRotation_rad = 1e-5;
  const double least_m = 1e-4 * spacing_m;
  return {std::max(scatter.along_m, least_m), std::max(scatter.across_m, least_m),
          std::max(scatter.rotation_rad, kLeastRotation_rad)};
}

RailScatter larger(const RailScatter& a, const RailScatter& b) {
  return {std::max(a.along_m, b.along_m), std::max(a.across_m, b.across_m),
          std::max(a.rotation_rad, b.rotation_rad)};
}

RailScatter measured_scatter(const CaptureSet& set, const Rail& rail,
                             const std::vector<std::size_t>& stations, const FramePoses& poses) {
  std::vector<double> along_m, across_m, turned_rad;
  for (const std::size_t frame : stations) {
    const RailDeviation deviation = deviation_of(set, rail, frame, *poses[frame]);
    along_m.push_back(std::abs(deviation.off_m[0]));
    for (const int axis : {1, 2}) across_m.push_back(std::abs(deviation.off_m[axis]));
    for (const double turned : deviation.turned_rad) turned_rad.push_back(std::abs(turned));
  }
  const auto count = static_cast<double>(stations.size());
  const auto sigma = [&](std::vector<double> deviations, double functions) {
    return robust_sigma(std::move(deviations)) *
           std::sqrt(count / std::max(1.0, count - functions));
  };
  const auto functions = static_cast<double>(functions_for(stations.size()));
  return {sigma(std::move(along_m), 1.0), sigma(std::move(across_m), std::min(functions, 4.0)),
          sigma(std::move(turned_rad), std::min(functions, 3.0))};
}

// The rail of the plan, moved and turned as the stations are in the median and the mean.
void start_at_stations(const CaptureSet& set, const std::vector<std::size_t>& stations,
                       const FramePoses& poses, Rail* rail) {
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  std::array<std::vector<double>, 3> moved_m;
  for (const std::size_t frame : stations) {
    turns += poses[frame]->world_from_camera * planned_attitude(set.frames[frame]).transpose();
    const Eigen::Vector3d moved =
        poses[frame]->position_m -
        rail_position(rail->frame, rail->parameters.data(), set.rail_m(frame));
    for (std::size_t axis = 0; axis < 3; ++axis) moved_m.at(axis).push_back(moved[axis]);
  }
  const Eigen::Vector3d turned_rad = vector_of(nearest_rotation(turns));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rail->parameters.at(P::kOffset + axis) = median(moved_m.at(axis));
    rail->parameters.at(P::kRotation + axis) = turned_rad[axis];
  }
}

// One step of the reweighted least squares: the rail for its present scatter.
void solve(const CaptureSet& set, const std::vector<std::size_t>& stations, const FramePoses& poses,
           Rail* rail) {
  std::vector<PoseParameters> parameters;
  parameters.reserve(stations.size());  // the problem holds their addresses
  ceres::Problem problem;
  auto* loss = new ceres::CauchyLoss(kCauchySigmas);  // owned by the problem
  for (const std::size_t frame : stations) {
    const Eigen::Vector3d& at_m = poses[frame]->position_m;
    parameters.push_back({0, 0, 0, at_m.x(), at_m.y(), at_m.z()});
    auto* cost = new ceres::AutoDiffCostFunction<RailCost, 6, 6, P::kCount>(
        new RailCost(*rail, set.rail_m(frame), poses[frame]->world_from_camera,
                     planned_attitude(set.frames[frame])));
    problem.AddResidualBlock(cost, loss, parameters.back().data(), rail->parameters.data());
    problem.SetParameterBlockConstant(parameters.back().data());
  }
  add_rail_prior(rail, &problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 20;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

void fit(const CaptureSet& set, const std::vector<std::size_t>& stations, const FramePoses& poses,
         double spacing_m, Rail* rail) {
  throw_if_interrupted();
  rail->stations = static_cast<int>(stations.size());
  keep_supported(stations.size(), rail);
  if (stations.empty()) return;
  start_at_stations(set, stations, poses, rail);
  for (int round = 0; round < kRounds; ++round) {
    rail->scatter = with_least(measured_scatter(set, *rail, stations, poses), spacing_m);
    solve(set, stations, poses, rail);
  }
  rail->scatter = with_least(measured_scatter(set, *rail, stations, poses), spacing_m);
}

// The median of the lines that measure their own, component by component. Else a twenty-fifth of
// the stations' spacing (1 mm of 25 mm) and a tenth of a degree: a rail is built to run straight.
RailScatter common_scatter(const std::vector<Rail>& rails, double spacing_m) {
  std::vector<double> along_m, across_m, rotation_rad;
  for (const Rail& rail : rails) {
    if (rail.stations < kStationsForScatter) continue;
    along_m.push_back(rail.scatter.along_m);
    across_m.push_back(rail.scatter.across_m);
    rotation_rad.push_back(rail.scatter.rotation_rad);
  }
  if (along_m.empty()) return {spacing_m / 25.0, spacing_m / 25.0, radians_from_degrees(0.1)};
  return {median(along_m), median(across_m), median(rotation_rad)};
}

}  // namespace

void add_rail_prior(Rail* rail, ceres::Problem* problem) {
  const double length_m = rail->frame.half_length_m;
  RailPriorCost prior{};
  std::fill_n(prior.sigmas.begin() + P::kOffset, 3, length_m);
  std::fill_n(prior.sigmas.begin() + P::kHeading, 2, kPlacing_rad);
  std::fill_n(prior.sigmas.begin() + P::kRotation, 3, kPlacing_rad);
  std::fill_n(prior.sigmas.begin() + P::kBow, 4, kRailBow * length_m);
  std::fill_n(prior.sigmas.begin() + P::kTwist, 6, kRailTwist_rad);
  problem->AddResidualBlock(new ceres::AutoDiffCostFunction<RailPriorCost, P::kCount, P::kCount>(
                                new RailPriorCost(prior)),
                            nullptr, rail->parameters.data());
  std::vector<int> held;
  for (int i = 0; i < P::kCount; ++i) {
    if (!rail->kept.at(i)) held.push_back(i);
  }
  if (held.empty()) return;
  problem->SetManifold(rail->parameters.data(), new ceres::SubsetManifold(P::kCount, held));
}

std::vector<Rail> fit_rails(const CaptureSet& set, const FramePoses& poses) {
  const double spacing_m = station_spacing_m(set);
  std::vector<Rail> rails(set.lines.size());
  parallel_for(0, static_cast<int>(rails.size()), 1, [&](int begin, int end) {
    for (int line = begin; line < end; ++line) {
      Rail& rail = rails[line];
      rail.frame = rail_frame(set, line);
      fit(set, posed_stations(set.lines[line], poses), poses, spacing_m, &rail);
    }
  });
  const RailScatter common = common_scatter(rails, spacing_m);
  for (Rail& rail : rails) {
    if (rail.stations < kStationsForScatter) rail.scatter = larger(rail.scatter, common);
  }
  return rails;
}

FramePose pose_on_rail(const CaptureSet& set, const Rail& rail, std::size_t frame) {
  const double rail_m = set.rail_m(frame);
  const RailScatter& scatter = rail.scatter;
  const double square_m2 =
      scatter.along_m * scatter.along_m + 2.0 * scatter.across_m * scatter.across_m;
  return {
      .position_m = rail_position(rail.frame, rail.parameters.data(), rail_m),
      .world_from_camera = matrix_of(rail_rotation(rail.frame, rail.parameters.data(), rail_m)) *
                           planned_attitude(set.frames[frame]),
      .origin = PoseOrigin::kRail,
      .position_sigma_mm = 1e3 * std::sqrt(square_m2 / 3.0),
      .rotation_sigma_deg = degrees_from_radians(scatter.rotation_rad)};
}

RailDeviation deviation_of(const CaptureSet& set, const Rail& rail, std::size_t frame,
                           const FramePose& pose) {
  const FramePose expected = pose_on_rail(set, rail, frame);
  const RailAxes<double> axes =
      rail_axes(rail.frame.axis, rail.parameters[P::kHeading], rail.parameters[P::kTilt]);
  const Eigen::Vector3d off_m = pose.position_m - expected.position_m;
  return {.off_m = {off_m.dot(axes.direction), off_m.dot(axes.across), off_m.dot(axes.up)},
          .turned_rad = vector_of(pose.world_from_camera * expected.world_from_camera.transpose())};
}

}  // namespace raywalk::calibrate
