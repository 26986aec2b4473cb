#include "calibrate/poses/align_poses.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "calibrate/base/rotation.h"
#include "core/base/error.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// The smallest spread, relative to the largest, that counts as a dimension: a rail's bow and jitter
// are a few thousandths of its length.
constexpr double kFlatShare = 0.01;
// Weight of the orientations relative to the centres: they decide only what the centres leave
// undetermined. A camera mounted a few degrees askew must not rotate the grid.
constexpr double kOrientationWeight = 1e-4;

std::vector<std::size_t> frames_with_both(const FramePoses& a, const FramePoses& b) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    if (a[i] && b[i]) both.push_back(i);
  }
  return both;
}

Eigen::Vector3d mean_position(const FramePoses& poses, const std::vector<std::size_t>& frames) {
  Eigen::Vector3d sum(0, 0, 0);
  for (const std::size_t i : frames) sum += poses[i]->position_m;
  return sum / static_cast<double>(frames.size());
}

// Ratios of feedback to solved distance, of every station and the one half a line further on: the
// longest distances that still give as many ratios as there are stations on half a line.
std::vector<double> rail_ratios(const CaptureSet& set, const FramePoses& solved) {
  std::vector<double> ratios;
  for (const CaptureLine& line : set.lines) {
    std::vector<std::size_t> posed;
    for (const std::size_t frame : line.frames) {
      if (solved[frame]) posed.push_back(frame);
    }
    const std::size_t half = posed.size() / 2;
    for (std::size_t i = 0; half > 0 && i + half < posed.size(); ++i) {
      const std::size_t a = posed[i];
      const std::size_t b = posed[i + half];
      const double solved_m = (solved[a]->position_m - solved[b]->position_m).norm();
      const double rail_m = set.nominal_distance_m(a, b);
      if (solved_m > 0.0 && rail_m > 0.0) ratios.push_back(rail_m / solved_m);
    }
  }
  return ratios;
}

}  // namespace

PoseAlignment align_poses(const CaptureSet& set, const FramePoses& solved,
                          const FramePoses& nominal) {
  const std::vector<std::size_t> frames = frames_with_both(solved, nominal);
  if (frames.empty()) throw Error("no frame has a solved pose to align");
  PoseAlignment alignment;
  alignment.frames = static_cast<int>(frames.size());
  const std::vector<double> ratios = rail_ratios(set, solved);
  alignment.scale_pairs = static_cast<int>(ratios.size());
  if (!ratios.empty()) alignment.scale = median(ratios);

  const Eigen::Vector3d solved_mean = mean_position(solved, frames);
  const Eigen::Vector3d nominal_mean = mean_position(nominal, frames);
  Eigen::Matrix3d orientations = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d centres = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const std::size_t i : frames) {
    orientations += nominal[i]->world_from_camera * solved[i]->world_from_camera.transpose();
    const Eigen::Vector3d to = nominal[i]->position_m - nominal_mean;
    centres += to * (alignment.scale * (solved[i]->position_m - solved_mean)).transpose();
    spread += to * to.transpose();
  }
  const double count = alignment.frames;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread / count);  // the least first
  alignment.spread_m = axes.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
  const double largest_m = alignment.spread_m[0];
  for (const double axis_m : alignment.spread_m) {
    if (largest_m > 0.0 && axis_m > kFlatShare * largest_m) ++alignment.rank;
  }
  Eigen::Matrix3d sum = kOrientationWeight * orientations;
  if (alignment.rank > 0) {
    // Without the components off the counted axes: they are bow and jitter.
    const auto counting = axes.eigenvectors().rightCols(alignment.rank);
    const double mean_square_m2 = spread.trace() / count;
    sum += counting * counting.transpose() * centres / mean_square_m2;
  }
  alignment.rotation = nearest_rotation(sum);
  alignment.translation_m = nominal_mean - alignment.scale * alignment.rotation * solved_mean;
  return alignment;
}

FramePoses aligned(const FramePoses& solved, const PoseAlignment& alignment) {
  FramePoses moved = solved;
  for (std::optional<FramePose>& pose : moved) {
    if (!pose) continue;
    pose->position_m =
        alignment.scale * alignment.rotation * pose->position_m + alignment.translation_m;
    pose->world_from_camera = alignment.rotation * pose->world_from_camera;
    pose->position_sigma_mm *= alignment.scale;
  }
  return moved;
}

}  // namespace raywalk::calibrate
