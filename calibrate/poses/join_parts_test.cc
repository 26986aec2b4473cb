#include "calibrate/poses/join_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "calibrate/base/rotation.h"
#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

PoseAlignment move(double scale, const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& by_m) {
  PoseAlignment alignment;
  alignment.scale = scale;
  alignment.rotation = matrix_of(turn_rad);
  alignment.translation_m = by_m;
  return alignment;
}

// The poses of some frames, moved as a whole.
FramePoses part_of(const FramePoses& truth, const std::vector<int>& frames,
                   const PoseAlignment& by) {
  FramePoses poses(truth.size());
  for (const int frame : frames) {
    const auto index = static_cast<std::size_t>(frame);
    poses[index] = truth[index];
    poses[index]->position_sigma_mm = 0.2;
    poses[index]->rotation_sigma_deg = 0.005;
  }
  return aligned(poses, by);
}

// x0 is cut off: its stations are shared where it crosses z0 and z1, with those of z0 and z1 there.
TEST(JoinParts, SimilaritiesOfKnownMovesAreFoundDespiteWrongPoses) {
  const CaptureSet set = test_grid(13);
  const FramePoses truth = test_truth(set, {}, 4);
  const PoseAlignment moved = move(1.0004, {0.01, -0.008, 0.012}, {0.02, -0.01, 0.015});
  std::vector<int> first;
  std::vector<int> second;
  for (int frame = 0; frame < 13; ++frame) first.push_back(frame);
  for (int frame = 2; frame < 52; ++frame) {
    if (frame < 9 || frame >= 13) second.push_back(frame);
  }
  for (int frame = 26; frame < 30; ++frame) first.push_back(frame);
  std::vector<FramePoses> parts{part_of(truth, second, {}), part_of(truth, first, moved)};
  const auto back = [&](const std::vector<PoseAlignment>& found) {
    return largest_difference(aligned(parts[1], found[1]), part_of(truth, first, {}));
  };
  PoseDifference left = back(similarities(parts, 0));
  // The scale's prior pulls a little.
  EXPECT_LT(left.position_m, 1e-4);
  EXPECT_LT(left.rotation_rad, 1e-4);

  // One shared station is wrong in one of them.
  parts[0][4]->position_m.y() += 0.05;
  parts[0][4]->world_from_camera *= matrix_of({0.0, 0.1, 0.0});
  left = back(similarities(parts, 0));
  EXPECT_LT(left.position_m, 1e-4);
  EXPECT_LT(left.rotation_rad, 1e-4);
}

struct Scene {
  CaptureSet set = test_grid(21);
  FramePoses truth = test_truth(set, {}, 5);
  PosesOptions options{.part_stations = 30};
  PoseProblem problem = problem_of(set, options);

  // What a part without errors finds, up to a similarity.
  PartSolution solution(std::size_t part, const PoseAlignment& moved) const {
    PartSolution solution;
    const PosePart& of = problem.parts[part];
    RefinedPoses& refined = solution.refined;
    refined.poses = part_of(truth, of.frames, {});
    const SeenPoints all = test_points(set, truth, 3000, 1.0, 0.0, 6);
    refined.points.points_m = all.points_m;
    std::copy_if(all.observations.begin(), all.observations.end(),
                 std::back_inserter(refined.points.observations),
                 [&](const PointObservation& observation) {
                   return refined.poses[static_cast<std::size_t>(observation.frame)].has_value();
                 });
    refined.points = widely_seen(refined.points, 2);
    refined.errors_px.assign(refined.points.observations.size(), 0.0);
    refined.poses = aligned(refined.poses, moved);
    for (Eigen::Vector3d& point : refined.points.points_m) {
      point = moved.scale * moved.rotation * point + moved.translation_m;
    }
    thin_for_joining(problem, of, &refined);
    return solution;
  }
};

TEST(JoinParts, PartsMeetAndSoDoTheirPoints) {
  const Scene scene;
  ASSERT_GE(scene.problem.parts.size(), 3U);
  std::vector<PartSolution> solutions;
  for (std::size_t part = 0; part < scene.problem.parts.size(); ++part) {
    const double size = 0.01 * static_cast<double>(part);
    solutions.push_back(
        scene.solution(part, move(1.0 + 0.1 * size, {size, 0.0, -size}, {size, size, 0.0})));
  }
  const JoinedParts joined = join_parts(scene.problem, solutions);
  const FramePoses truth =
      aligned(scene.truth, align_poses(scene.set, scene.truth, scene.problem.nominal));
  EXPECT_EQ(std::count(joined.poses.begin(), joined.poses.end(), std::nullopt), 0);
  const PoseDifference left = largest_difference(joined.poses, truth);
  EXPECT_LT(left.position_m, 5e-4);
  EXPECT_LT(left.rotation_rad, 5e-4);
  double worst_px = 0.0;
  std::set<std::pair<int, double>> seen;
  for (const PointObservation& observation : joined.points.observations) {
    const FramePose& pose = *joined.poses[static_cast<std::size_t>(observation.frame)];
    worst_px = std::max(
        worst_px,
        bearing_error_px(observation, pose.world_from_camera, pose.position_m,
                         joined.points.points_m[static_cast<std::size_t>(observation.point)]));
    // No observation counts twice.
    EXPECT_TRUE(seen.insert({observation.frame, observation.bearing.x()}).second);
  }
  EXPECT_LT(worst_px, 0.5);
  EXPECT_GT(seen.size(), 5000U);

  // A part that was not solved leaves its frames out.
  solutions[1].refined = {};
  const JoinedParts without = join_parts(scene.problem, solutions);
  EXPECT_GT(std::count(without.poses.begin(), without.poses.end(), std::nullopt), 3);
}

}  // namespace
}  // namespace raywalk::calibrate
