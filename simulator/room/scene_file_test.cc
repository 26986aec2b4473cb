#include "simulator/room/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr const char* kPaint = "materials: [{name: paint, base: [0.2, 0.3, 0.4]}]\n";
constexpr const char* kWall =
    "solids: [{quad: [-1, 0, 2, 1, 0, 2, 1, 1, 2, -1, 1, 2], material: paint}]\n";

Scene scene_of(const std::string& yaml) { return parse_scene(yaml, "scene.yaml"); }

void expect_bad_scene(const std::string& yaml, const std::string& message) {
  try {
    scene_of(yaml);
    ADD_FAILURE() << yaml;
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr(message));
  }
}

std::string painted(const std::string& solid) {
  return std::string(kPaint) + "solids:\n  - {material: paint, " + solid + "}\n";
}

TEST(SceneFileTest, EverySolidIsMade) {
  EXPECT_EQ(scene_of(painted("box: [0, 0, 0, 1, 1, 1]")).room.facets.size(), 6U);
  EXPECT_EQ(scene_of(painted("panel: [0, 0, 0, 1, 1, 1]")).room.facets.size(), 5U);
  EXPECT_EQ(scene_of(painted("rod: [0, 0, 0, 0, 1, 0, 0.1, 0.2]")).room.facets.size(), 22U);
  EXPECT_EQ(scene_of(painted("globe: [0, 1, 0, 0.2, 0.2]")).room.facets.size(), 512U);
  const Facet wall = scene_of(std::string(kPaint) + kWall).room.facets.at(0);
  EXPECT_LT((wall.normal - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_FALSE(wall.shell || wall.two_sided);
  const Facet turned =
      scene_of(painted("box: [0, 0, 0, 1, 1, 1], at: [3, 0, 0], yaw_deg: 90, shell: true"))
          .room.facets.at(4);
  EXPECT_TRUE(turned.shell);
  EXPECT_LT((turned.normal - Vector3d(-1, 0, 0)).norm(), 1e-12) << "the side towards -z";
}

TEST(SceneFileTest, MaterialsHaveTheirPatternAndColours) {
  const Scene scene = scene_of(
      "materials:\n  - {name: floor, pattern: tiles, base: [0.1, 0.2, 0.3],\n"
      "     accent: [0.4, 0.5, 0.6], period_m: 0.3, size_m: [2, 3], seed: 4000000000}\n"
      "solids: [{box: [0, 0, 0, 1, 1, 1], material: floor}]\n");
  const Surface& floor = scene.room.surfaces.at(0);
  EXPECT_EQ(floor.pattern, Pattern::kTiles);
  EXPECT_EQ(floor.base, Color(0.1F, 0.2F, 0.3F));
  EXPECT_EQ(floor.accent, Color(0.4F, 0.5F, 0.6F));
  EXPECT_EQ(floor.period, 0.3F);
  EXPECT_EQ(floor.extent, Eigen::Vector2f(2, 3));
  EXPECT_EQ(floor.seed, 4000000000U);
}

// Windows are of sky, lamps are globes that shine; panes of glass stand apart.
TEST(SceneFileTest, LightsAreFoundAmongTheSolids) {
  const Scene scene = scene_of(
      "sun: [0, 2e-1, -1e-1]\nlamp_reach_m: 5\nlight_step_m: 0.2\nsky_seed: 7\n"
      "materials: [{name: a, pattern: sky}, {name: b, pattern: lamp}, {name: c, pattern: glass}]\n"
      "solids:\n"
      "  - {quad: [-1, 0, 2, 1, 0, 2, 1, 1, 2, -1, 1, 2], material: a}\n"
      "  - {globe: [0, 1, 0, 0.1, 0.2], material: b}\n"
      "  - {quad: [-1, 0, 1, 1, 0, 1, 1, 1, 1, -1, 1, 1], material: c}\n"
      "objects: [{name: lantern, solids: [{globe: [0, 0, 0, 0.3, 0.3], material: b}]}]\n"
      "instances: [{object: lantern, at: [3, 1, 0]}]\n");
  ASSERT_EQ(scene.lights.windows.size(), 1U);
  EXPECT_EQ(scene.lights.windows[0].edge_s, Vector3d(2, 0, 0));
  ASSERT_EQ(scene.lights.lamps.size(), 2U);
  EXPECT_EQ(scene.lights.lamps[1].centre, Vector3d(3, 1, 0));
  EXPECT_EQ(scene.lights.lamps[1].radius, 0.3);
  EXPECT_EQ(scene.lights.lamp_reach, 5.0);
  EXPECT_EQ(scene.lights.sky_seed, 7U);
  EXPECT_NEAR(scene.lights.sun->y(), 2.0 / std::sqrt(5.0), 1e-12);
  EXPECT_EQ(scene.glass.size(), 1U);
  EXPECT_EQ(scene.room.facets.size(), 1U + 2U * 512U);
}

TEST(SceneFileTest, InstancesStandOrWalkRoundTheirLoop) {
  const Scene scene = scene_of(
      std::string(kPaint) +
      "objects: [{name: post, solids: [{rod: [0, 0, 0, 0, 1, 0, 0.1, 0.1], material: paint}]}]\n"
      "instances:\n"
      "  - {object: post, at: [1, 0, 2]}\n"
      "  - {object: post, at: [0, 0.5, 0], loop: [0, 0, 0, 2, 2, 2], start_m: 1, step_m: 1.5}\n");
  EXPECT_EQ(scene.room.facets.size(), 22U);
  ASSERT_EQ(scene.moving.size(), 1U);
  EXPECT_EQ(scene.moving[0].at(0).origin, Vector3d(0, 0.5, 1));
  EXPECT_EQ(scene.moving[0].at(0).yaw_rad, 0.0);
  EXPECT_LT((scene.moving[0].at(1).origin - Vector3d(0.5, 0.5, 2)).norm(), 1e-12);
  EXPECT_NEAR(scene.moving[0].at(1).yaw_rad, std::acos(0.0), 1e-12) << "along x";
  const double length = 4.0 + std::sqrt(8.0);
  const double back = (1.0 + 3 * 1.5 - 4.0) / std::sqrt(2.0);
  EXPECT_LT((scene.moving[0].at(3).origin - Vector3d(2 - back, 0.5, 2 - back)).norm(), 1e-12);
  EXPECT_GT(length, 5.5);
}

// What includes others has the last word.
TEST(SceneFileTest, IncludedScenesCanBeChanged) {
  const TestDirectory directory;
  write_file_atomically(directory / "base.yaml",
                        std::string("light_step_m: 0.3\nsky_seed: 1\n") + kPaint + kWall);
  write_file_atomically(directory / "own.yaml",
                        "include: [base.yaml]\nsky_seed: 2\n"
                        "materials: [{name: paint, pattern: bricks}]\n");
  const Scene scene = read_scene(directory / "own.yaml");
  EXPECT_EQ(scene.lights.grid_step, 0.3);
  EXPECT_EQ(scene.lights.sky_seed, 2U);
  ASSERT_EQ(scene.room.facets.size(), 1U);
  EXPECT_EQ(scene.room.surfaces.at(0).pattern, Pattern::kBricks);
  write_file_atomically(directory / "base.yaml", "include: [own.yaml]\n");
  EXPECT_THROW(read_scene(directory / "own.yaml"), UsageError);
}

// A square of two triangles with a picture: red at the left, blue at the right.
TEST(SceneFileTest, MeshesAreReadWithTheirMaterials) {
  const TestDirectory directory;
  cv::Mat picture(64, 64, CV_8UC3, cv::Scalar(0, 0, 255));
  picture.colRange(32, 64).setTo(cv::Scalar(255, 0, 0));
  cv::imwrite((directory / "map.png").string(), picture);
  write_file_atomically(directory / "square.mtl", "newmtl cloth\nKd 1 1 1\nmap_Kd map.png\n");
  write_file_atomically(directory / "square.obj",
                        "mtllib square.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\n"
                        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl cloth\nf 1/1 2/2 3/3 4/4\n");
  const Scene scene = parse_scene("solids: [{mesh: square.obj, scale: 0.5, at: [0, 0, 3]}]\n",
                                  "scene.yaml", directory.path());
  ASSERT_EQ(scene.room.facets.size(), 2U);
  const Facet& facet = scene.room.facets.front();
  EXPECT_LT((facet.normal - Vector3d(0, 0, -1)).norm(), 1e-6) << "towards the viewer";
  EXPECT_LT((facet.corners[0] - Vector3d(-0.5, 0, 3.5)).norm(), 1e-6) << "z of OBJ is backwards";
  const Surface& cloth = scene.room.surfaces[static_cast<std::size_t>(facet.surface)];
  const auto colour_at = [&](double x, double y) {
    const Vector3d from = Vector3d(x, y, 3.5) - facet.texture.origin;
    const Eigen::Vector2d at =
        facet.texture.at_origin +
        Eigen::Vector2d(from.dot(facet.texture.s_axis), from.dot(facet.texture.t_axis));
    return albedo_at(cloth, at.cast<float>(), 0.01F);
  };
  EXPECT_LT((colour_at(-0.25, 0.5) - Color(1, 0, 0)).norm(), 0.01F);
  EXPECT_LT((colour_at(0.25, 0.5) - Color(0, 0, 1)).norm(), 0.01F);
  // Far away, or through a coarse pixel, the mean.
  EXPECT_LT((albedo_at(cloth, {0.5F, 0.5F}, 4.0F) - Color(0.5F, 0, 0.5F)).norm(), 0.05F);
}

TEST(SceneFileTest, MistakesAreNamedWithTheirLine) {
  expect_bad_scene("", "no solids");
  expect_bad_scene("solids:\n  - {bocks: [1]}\n", "scene.yaml:2: unknown key 'solids[0].bocks'");
  expect_bad_scene(painted("box: [0, 0, 0, 1, 1]"), "scene.yaml:3: 'solids[0].box' has 5 numbers");
  expect_bad_scene(painted("yaw_deg: 3"), "scene.yaml:3: 'solids[0]' needs a box");
  expect_bad_scene(painted("rod: [0, 0, 0, 0, 0, 0, 1, 1]"), "has no size");
  expect_bad_scene(painted("quad: [0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0]"), "has no size");
  expect_bad_scene(painted("globe: [0, 0, 0, 0, 1]"), "has no size");
  expect_bad_scene(
      std::string(kPaint) + "solids: [{box: [0, 0, 0, 1, 1, 1], material: pain}]\n",
      "scene.yaml:2: 'solids[0].material' is no material: 'pain'; did you mean 'paint'?");
  expect_bad_scene("instances:\n  - {object: chair}\n",
                   "'instances[0].object' is no object: 'chair'");
  expect_bad_scene("solids: [{mesh: nowhere.obj}]\n", "'solids[0].mesh' cannot be used");
  expect_bad_scene("materials: [{name: a, pattern: picture, file: b.png}]\n", "b.png");
  expect_bad_scene("materials: [{name: a, pattern: picture}]\n", "needs a 'file'");
  expect_bad_scene("sun: [0, 0, 0]\n", "has no direction");
  expect_bad_scene("include: [nowhere]\n", "nowhere");
}

TEST(SceneFileTest, ShippedScenesAreValid) {
  const std::vector<std::string> names = shipped_config_names(ConfigKind::kScene);
  EXPECT_GE(names.size(), 8U);
  for (const std::string& name : names) {
    if (name == "person") continue;  // objects only
    EXPECT_GT(read_scene(config_path(name, ConfigKind::kScene)).room.facets.size(), 5U) << name;
  }
}

}  // namespace
}  // namespace raywalk::simulator
