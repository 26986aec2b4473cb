#include "calibrate/poses/part_solution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/poses/test_rail_scene.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

PartSolution some_solution() {
  const CaptureSet set = test_grid(5);
  PartSolution solution;
  solution.colmap = "3.8";
  solution.features = {{0, 700}, {3, 12}};
  solution.matches = {{3, 1}};
  solution.matched_pairs = 17;
  solution.evidence = {{0.1, -2.0}, {}, {1e-300}, {}};
  solution.times = {{"faces", 0.1, true}, {"features", 2.0 / 3.0, false}};
  solution.refined.poses = test_truth(set, {}, 1);
  solution.refined.poses[2].reset();
  solution.refined.poses[4]->position_sigma_mm = 0.3;
  solution.refined.poses[4]->rotation_sigma_deg = 0.01;
  solution.refined.poses[4]->observations = 77;
  solution.refined.poses[4]->residual_px = 0.2;
  solution.refined.points = test_points(set, solution.refined.poses, 10, 1.0, 0.5, 2);
  solution.refined.errors_px.assign(solution.refined.points.observations.size(), 0.7);
  solution.refined.noise_px = 0.11;
  solution.refined.inlier_px = 0.44;
  return solution;
}

TEST(PartSolution, IsReadAsWritten) {
  const PartSolution solution = some_solution();
  const std::string bytes = bytes_of(solution);
  const PartSolution read = read_part_solution(bytes, 20, 4, "part 1 of 2");
  EXPECT_EQ(bytes_of(read), bytes);
  EXPECT_EQ(read.colmap, "3.8");
  EXPECT_EQ(read.features, solution.features);
  EXPECT_EQ(read.matches, solution.matches);
  EXPECT_EQ(read.matched_pairs, 17);
  EXPECT_EQ(read.evidence, solution.evidence);
  EXPECT_EQ(read.times[1].step, "features");
  EXPECT_EQ(read.times[1].seconds, 2.0 / 3.0);
  EXPECT_TRUE(read.times[0].reused);
  EXPECT_FALSE(read.refined.poses[2]);
  EXPECT_EQ(read.refined.poses[4]->world_from_camera, solution.refined.poses[4]->world_from_camera);
  EXPECT_EQ(read.refined.poses[4]->position_m, solution.refined.poses[4]->position_m);
  EXPECT_EQ(read.refined.poses[4]->position_sigma_mm, 0.3);
  EXPECT_EQ(read.refined.poses[4]->rotation_sigma_deg, 0.01);
  EXPECT_EQ(read.refined.poses[4]->observations, 77);
  EXPECT_EQ(read.refined.points.points_m[9], solution.refined.points.points_m[9]);
  EXPECT_EQ(read.refined.points.observations.back().bearing,
            solution.refined.points.observations.back().bearing);
  EXPECT_EQ(read.refined.errors_px, solution.refined.errors_px);
  EXPECT_EQ(read.refined.inlier_px, 0.44);
  EXPECT_TRUE(read.solved());
}

TEST(PartSolution, DamagedBytesAreRefused) {
  const std::string bytes = bytes_of(some_solution());
  const auto refusal = [](const std::string& text, std::size_t frames) -> std::string {
    try {
      read_part_solution(text, frames, 4, "part 1 of 2");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(bytes, 20), "");
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    EXPECT_THAT(refusal(bytes.substr(0, size), 20), testing::HasSubstr("part 1 of 2 are damaged"));
  }
  EXPECT_NE(refusal(bytes + "x", 20), "");
  EXPECT_NE(refusal(bytes, 19), "");
}

}  // namespace
}  // namespace raywalk::calibrate
