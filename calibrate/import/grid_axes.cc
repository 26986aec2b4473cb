#include "calibrate/import/grid_axes.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include "calibrate/base/rotation.h"
#include "calibrate/import/imported_poses.h"
#include "core/base/error.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {
namespace {

// How much narrower than long a set of stations is before it counts as one line.
constexpr double kLineShare = 0.1;
// Of the cameras' mean up or forward, whose length is 1 if all agree.
constexpr double kAgreement = 0.5;
constexpr double kMostLean_deg = 45.0;

[[noreturn]] void fail(const std::string& what) {
  throw Error(what + "; give --axes keep to take the axes as they are");
}

Eigen::Vector3d mean_axis(const std::vector<ImportedFrame>& frames, int axis) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImportedFrame& frame : frames) sum += frame.pose.world_from_camera.col(axis);
  return sum / static_cast<double>(frames.size());
}

Eigen::Vector3d cameras_up(const std::vector<ImportedFrame>& frames) {
  const Eigen::Vector3d up = mean_axis(frames, 1);
  if (up.norm() < kAgreement) fail("the cameras have no common up direction");
  return up.normalized();
}

// The mean of positions, the directions in which they spread, least first, and how far.
struct Spread {
  Eigen::Vector3d mean;
  Eigen::Matrix3d axes;
  Eigen::Vector3d deviation;
};

Spread spread_of(const std::vector<Eigen::Vector3d>& positions) {
  const auto count = static_cast<double>(positions.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& position : positions) mean += position / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& position : positions) {
    covariance += (position - mean) * (position - mean).transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return {mean, solver.eigenvectors(), solver.eigenvalues().cwiseMax(0.0).cwiseSqrt()};
}

Eigen::Vector3d up_of(const std::vector<ImportedFrame>& frames) {
  const Eigen::Vector3d cameras = cameras_up(frames);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(frames.size());
  for (const ImportedFrame& frame : frames) positions.push_back(frame.pose.position_m);
  const Spread spread = spread_of(positions);
  if (spread.deviation[2] == 0.0) throw Error("all panoramas are at one place");
  if (spread.deviation[1] < kLineShare * spread.deviation[2]) {
    const Eigen::Vector3d along = spread.axes.col(2);
    const Eigen::Vector3d up = cameras - cameras.dot(along) * along;
    if (up.norm() < kAgreement) fail("the cameras' up is along the only line");
    return up.normalized();
  }
  Eigen::Vector3d normal = spread.axes.col(0);
  if (normal.dot(cameras) < 0.0) normal = -normal;
  const double lean_deg =
      degrees_from_radians(std::atan2(normal.cross(cameras).norm(), normal.dot(cameras)));
  if (lean_deg > kMostLean_deg) {
    fail(fmt::format("the plane of the stations leans by {:.0f} degrees against the cameras' up",
                     lean_deg));
  }
  return normal;
}

// The least turn of a direction to +y. Eigen::Quaterniond::FromTwoVectors takes 8 s to compile.
Eigen::Matrix3d turn_to_y(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis = direction.cross(Eigen::Vector3d::UnitY());
  if (axis.norm() == 0.0) return matrix_of({direction.y() < 0.0 ? kPi : 0.0, 0.0, 0.0});
  return matrix_of(std::atan2(axis.norm(), direction.y()) * axis.normalized());
}

Eigen::Matrix3d turn_about_y(double angle_rad) { return world_from_camera({angle_rad, 0.0, 0.0}); }

// The angle, within 45 degrees, by which most steps to the two nearest stations are turned from x
// or z towards each other: the mean of four times the angle, in which the axes are alike.
double first_turn(const std::vector<StationPose>& stations) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    std::vector<std::complex<double>> steps;
    for (std::size_t j = 0; j < stations.size(); ++j) {
      const Eigen::Vector3d step = stations[j].position_m - stations[i].position_m;
      if (j != i && std::hypot(step.x(), step.z()) > 0.0) steps.emplace_back(step.z(), step.x());
    }
    const auto nearest = std::min<std::size_t>(2, steps.size());
    std::partial_sort(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(nearest),
                      steps.end(), [](auto a, auto b) { return std::norm(a) < std::norm(b); });
    for (std::size_t j = 0; j < nearest; ++j) sum += std::pow(steps[j] / std::abs(steps[j]), 4);
  }
  return 0.25 * std::arg(sum);
}

// The mean angle by which the grid's lines are turned from their axes towards +x from +z, weighted
// by how well their stations determine it.
double turn_of_lines(const Grid& grid) {
  double sum = 0.0, weights = 0.0;
  for (const Line& line : grid.lines) {
    // Of a line along x the direction has the angle 90 degrees in this sense.
    const double angle = line.axis == LineAxis::kX
                             ? -std::atan2(line.direction.z_m, line.direction.x_m)
                             : std::atan2(line.direction.x_m, line.direction.z_m);
    double mean_m = 0.0, weight = 0.0;
    for (const Station& station : line.stations) {
      mean_m += station.along_m / static_cast<double>(line.stations.size());
    }
    for (const Station& station : line.stations) {
      weight += (station.along_m - mean_m) * (station.along_m - mean_m);
    }
    sum += weight * angle;
    weights += weight;
  }
  return sum / weights;
}

// A quarter turn, or none, one or two, after which the cameras' common direction is nearest to +z.
// By the least turn if there is no such direction.
double quarter_turns(const std::vector<ImportedFrame>& frames, const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d ahead = rotation * mean_axis(frames, 2);
  if (std::hypot(ahead.x(), ahead.z()) < kAgreement) return 0.0;
  return -kHalfPi * std::round(std::atan2(ahead.x(), ahead.z()) / kHalfPi);
}

double mean_cell_side(const Grid& grid) {
  double sum = 0.0;
  for (const Cell& cell : grid.cells) {
    sum += 0.5 * (cell.x_max_m - cell.x_min_m + cell.z_max_m - cell.z_min_m);
  }
  return sum / static_cast<double>(grid.cells.size());
}

double distance_of(const ImportedPoses& poses, const KnownDistance& known) {
  const FrameSearch search(poses.frames);
  const auto position = [&](const std::string& name) {
    const auto frame = search.find(name);
    if (!frame) {
      throw UsageError(fmt::format("--distance: {} is none of the {} panoramas, such as {}",
                                   excerpt(name), poses.frames.size(),
                                   excerpt(poses.frames.front().file)));
    }
    return poses.frames[*frame].pose.position_m;
  };
  const double units = (position(known.first) - position(known.second)).norm();
  if (units == 0.0) throw Error("--distance: both panoramas are at one place");
  return units;
}

// The scale as far as it is known without the grid: 1 for one that is known by its cells. The axes
// are upright already, as spacings are measured in the plan.
double scale_before_grid(const ImportedPoses& poses, const KnownScale& known,
                         const GridAxes& axes) {
  if (known.metres_per_unit) return *known.metres_per_unit;
  if (known.distance) return known.distance->metres / distance_of(poses, *known.distance);
  if (!known.spacing_m) return 1.0;
  const double spacing = typical_spacing(stations_of(poses.frames, axes));
  if (spacing == 0.0) throw Error("all panoramas are at one place");
  return *known.spacing_m / spacing;
}

double scale_by_cells(const Grid& grid, const KnownScale& known) {
  if (!known.cell_m) return 1.0;
  if (grid.cells.empty()) {
    throw Error("--cell-m: the lines close no cell; give --spacing-mm, --distance or --scale");
  }
  return *known.cell_m / mean_cell_side(grid);
}

void apply_scale(double scale, GridAxes* axes) {
  axes->scale *= scale;
  axes->translation_m *= scale;
}

Eigen::Vector3d middle_of(const Grid& grid, const std::vector<StationPose>& stations) {
  Eigen::Vector2d least(1e300, 1e300), most(-1e300, -1e300);
  const auto include = [&](double x, double z) {
    least = least.cwiseMin(Eigen::Vector2d(x, z));
    most = most.cwiseMax(Eigen::Vector2d(x, z));
  };
  double height = 0.0;
  for (const StationPose& station : stations) {
    height += station.position_m.y() / static_cast<double>(stations.size());
    if (grid.cells.empty()) include(station.position_m.x(), station.position_m.z());
  }
  for (const Cell& cell : grid.cells) {
    include(cell.x_min_m, cell.z_min_m);
    include(cell.x_max_m, cell.z_max_m);
  }
  const Eigen::Vector2d middle = 0.5 * (least + most);
  return {middle.x(), height, middle.y()};
}

}  // namespace

CameraPose moved(const GridAxes& axes, const CameraPose& pose) {
  return {axes.scale * (axes.rotation * pose.position_m) + axes.translation_m,
          axes.rotation * pose.world_from_camera};
}

std::vector<StationPose> stations_of(const std::vector<ImportedFrame>& frames,
                                     const GridAxes& axes) {
  std::vector<StationPose> stations;
  stations.reserve(frames.size());
  for (const ImportedFrame& frame : frames) {
    stations.push_back({.file = frame.file,
                        .position_m = moved(axes, frame.pose).position_m,
                        .where = frame.where});
  }
  return stations;
}

GridAxes fit_grid_axes(const ImportedPoses& poses, const AxesOptions& options) {
  GridAxes axes;
  if (options.fit && !poses.in_world) axes.rotation = turn_to_y(up_of(poses.frames));
  axes.scale = scale_before_grid(poses, options.scale, axes);
  // Where cells tell the scale, nothing is in metres before they are found.
  const GridTolerance tolerance = options.scale.cell_m ? GridTolerance{} : options.tolerance;
  const auto grid_so_far = [&] { return find_grid(stations_of(poses.frames, axes), tolerance); };
  if (!options.fit) {
    if (options.scale.cell_m) apply_scale(scale_by_cells(grid_so_far(), options.scale), &axes);
    return axes;
  }
  axes.rotation = turn_about_y(-first_turn(stations_of(poses.frames, axes))) * axes.rotation;
  // The first turn is by single steps; whole lines determine it better.
  axes.rotation = turn_about_y(-turn_of_lines(grid_so_far())) * axes.rotation;
  axes.rotation = turn_about_y(quarter_turns(poses.frames, axes.rotation)) * axes.rotation;
  const Grid grid = grid_so_far();
  axes.translation_m = -middle_of(grid, stations_of(poses.frames, axes));
  apply_scale(scale_by_cells(grid, options.scale), &axes);
  return axes;
}

GridAxes fit_known_positions(const ImportedPoses& poses, const std::vector<KnownPosition>& known) {
  if (known.size() < 3) throw Error("--reference: give the positions of at least three panoramas");
  std::vector<Eigen::Vector3d> from, to;
  from.reserve(known.size());
  to.reserve(known.size());
  for (const KnownPosition& position : known) {
    from.push_back(poses.frames[position.frame].pose.position_m);
    to.push_back(position.position_m);
  }
  const Spread spread = spread_of(from), known_spread = spread_of(to);
  const auto on_a_line = [](const Eigen::Vector3d& deviation) {
    return deviation[1] <= 1e-3 * deviation[2];
  };
  if (on_a_line(spread.deviation) || on_a_line(known_spread.deviation)) {
    throw Error("--reference: the positions are on one line; give some of another line too");
  }
  // Umeyama 1991, "Least-squares estimation of transformation parameters between two point
  // patterns". Eigen::umeyama takes 4 s to compile.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - known_spread.mean) * (from[i] - spread.mean).transpose() /
                  static_cast<double>(from.size());
  }
  const Eigen::Matrix3d rotation = nearest_rotation(covariance);
  const double scale = (rotation.transpose() * covariance).trace() / spread.deviation.squaredNorm();
  return {.scale = scale,
          .rotation = rotation,
          .translation_m = known_spread.mean - scale * (rotation * spread.mean)};
}

}  // namespace raywalk::calibrate
