#include "calibrate/grid/held_out_poses.h"

#include <algorithm>
#include <set>

#include "calibrate/grid/rail_model.h"
#include "calibrate/poses/align_poses.h"

namespace raywalk::calibrate {
namespace {

// What the grid made of a station's solved pose.
struct Correction {
  Eigen::Vector3d at_m{0, 0, 0};  // of the solved pose
  Eigen::Vector3d moved_m{0, 0, 0};
  Eigen::Vector3d turned_rad{0, 0, 0};  // rotation vector, world axes
};

// Of stations whose solved pose was not rejected as an outlier.
std::vector<Correction> corrections_of(const FramePoses& in_world, const GridResult& result) {
  std::set<std::size_t> rejected;
  for (const LineFit& line : result.lines) {
    rejected.insert(line.rejected_frames.begin(), line.rejected_frames.end());
  }
  std::vector<Correction> corrections;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    if (!in_world[i] || !result.poses[i] || rejected.contains(i)) continue;
    const FramePose &solved = *in_world[i], &estimated = *result.poses[i];
    corrections.push_back({.at_m = solved.position_m,
                           .moved_m = estimated.position_m - solved.position_m,
                           .turned_rad = vector_of(estimated.world_from_camera *
                                                   solved.world_from_camera.transpose())});
  }
  return corrections;
}

// Mean, weighted by the inverse square of the distance; stations nearer than their spacing count
// alike.
void correct(const std::vector<Correction>& corrections, double spacing_m, FramePose* pose) {
  double weights = 0.0;
  Eigen::Vector3d moved_m(0, 0, 0), turned_rad(0, 0, 0);
  for (const Correction& station : corrections) {
    const double away_m = std::max((station.at_m - pose->position_m).norm(), spacing_m);
    const double weight = 1.0 / (away_m * away_m);
    weights += weight;
    moved_m += weight * station.moved_m;
    turned_rad += weight * station.turned_rad;
  }
  pose->position_m += moved_m / weights;
  pose->world_from_camera = matrix_of(turned_rad / weights) * pose->world_from_camera;
}

}  // namespace

FramePoses held_out_poses(const CaptureSet& set, const FramePoses& solved,
                          const GridResult& result) {
  const CaptureSet stations = stations_only(set);
  FramePoses poses(set.frames.size() - stations.frames.size());
  const bool any = std::any_of(solved.begin(), solved.begin() + std::ssize(stations.frames),
                               [](const auto& pose) { return pose.has_value(); });
  if (poses.empty() || !any) return poses;
  const FramePoses in_world = aligned(solved, align_poses(set, solved, nominal_poses(stations)));
  const std::vector<Correction> corrections = corrections_of(in_world, result);
  if (corrections.empty()) return poses;
  const double spacing_m = grid_scale(stations).spacing_m;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = in_world[stations.frames.size() + i];
    if (poses[i]) correct(corrections, spacing_m, &*poses[i]);
  }
  return poses;
}

}  // namespace raywalk::calibrate
