#include "simulator/room/scene_file.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_support.h"
#include "core/files/test_yaml_keys.h"
#include "core/geometry/sphere.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/noise.h"
#include "simulator/room/room_settings.h"
#include "simulator/room/shapes.h"
#include "simulator/room/surface.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr const char* kPaint = "materials: [{name: paint, base: [0.2, 0.3, 0.4]}]\n";
constexpr const char* kWall =
    "solids: [{quad: [-1, 0, 2, 1, 0, 2, 1, 1, 2, -1, 1, 2], material: paint}]\n";

Scene scene_of(const std::string& yaml) { return parse_scene(yaml, "scene.yaml"); }

void expect_bad_scene(const std::string& yaml, const std::string& message) {
  EXPECT_THAT(error_of([&] { scene_of(yaml); }), HasSubstr(message));
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
  const double back = (1.0 + 3 * 1.5 - 4.0) / std::sqrt(2.0);
  EXPECT_LT((scene.moving[0].at(3).origin - Vector3d(2 - back, 0.5, 2 - back)).norm(), 1e-12);
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

// --- Settings of a room --------------------------------------------------------------------------

VirtualRoomSettings parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "room.yaml", yaml);
  return read_virtual_room_settings(directory / "room.yaml");
}

void expect_refused(const std::string& yaml, const std::string& message) {
  EXPECT_THAT(error_of([&] { parsed(yaml); }), HasSubstr(message));
}

// The shipped file claims that its values are the defaults.
TEST(RoomSettingsTest, ShippedFileHoldsEveryKeyWithItsDefault) {
  constexpr const char* kShipped = RAYWALK_CONFIGS "/virtual-room.yaml";
  VirtualRoomSettings defaults = parsed(""), shipped = read_virtual_room_settings(kShipped);
  const auto values = virtual_room_schema(&defaults).values();
  EXPECT_EQ(virtual_room_schema(&shipped).values(), values);
  std::set<std::string> known;
  for (const auto& entry : values) known.insert(entry.first);
  EXPECT_EQ(keys_of_yaml(kShipped), known);
}

TEST(RoomSettingsTest, EveryGroupIsRead) {
  const VirtualRoomSettings settings = parsed(
      "seed: 7\nscene:\n  file: hall\n  y_m: 0.2\ngrid:\n  cell_side_m: 0.5\n  cells_x: 2\n"
      "light:\n  clip: true\nsensor:\n  gain_spread: 0.1\npose:\n  position_jitter_mm: 2\noutput:\n"
      "  format: png\n");
  EXPECT_EQ(settings.seed, 7);
  EXPECT_EQ(settings.grid.cell_side_m, 0.5);
  EXPECT_EQ(settings.grid.cells_x, 2);
  EXPECT_EQ(settings.scene.file, "hall");
  EXPECT_EQ(settings.scene.middle_m, Eigen::Vector3d(0, 0.2, 0));
  EXPECT_TRUE(settings.light.clip);
  EXPECT_EQ(settings.sensor.gain_spread, 0.1);
  EXPECT_EQ(settings.pose.position_jitter_mm, 2.0);
  EXPECT_EQ(settings.output.format, "png");
}

TEST(RoomSettingsTest, MistakesAreNamedWithTheirLine) {
  expect_refused("seed: 1\ngrid:\n  cell_side: 1\n", ":3: unknown key 'grid.cell_side'");
  expect_refused("grid:\n  cell_side_m: 0\n", "must lie between");
  expect_refused("output:\n  width_px: 130\n", "multiple of 4");
}

TEST(RoomSettingsTest, ScenesBesideTheSettingsAreFound) {
  const TestDirectory directory;
  write_file_atomically(directory / "mine.yaml", "");
  write_file_atomically(directory / "room.yaml", "scene: {file: mine.yaml}\n");
  EXPECT_EQ(read_virtual_room_settings(directory / "room.yaml").scene.file,
            directory / "mine.yaml");
}

// --- Shapes --------------------------------------------------------------------------------------

// Divergence theorem: a closed surface with outward normals encloses 1/3 sum (p . n) A.
double enclosed_volume(const std::vector<Facet>& facets) {
  double volume = 0.0;
  for (const Facet& facet : facets) {
    const auto& c = facet.corners;
    const double area =
        0.5 * ((c[1] - c[0]).cross(c[3] - c[0]).norm() + (c[1] - c[2]).cross(c[3] - c[2]).norm());
    volume += area * facet.normal.dot(c[0]) / 3.0;
  }
  return volume;
}

void expect_flat(const std::vector<Facet>& facets) {
  for (const Facet& facet : facets) {
    EXPECT_NEAR(facet.normal.norm(), 1.0, 1e-9);
    for (const Vector3d& corner : facet.corners) {
      EXPECT_NEAR(facet.normal.dot(corner - facet.corners[0]), 0.0, 1e-9);
    }
  }
}

TEST(ShapesTest, BoxIsClosedWhereverItStands) {
  std::vector<Facet> facets;
  add_box({{3, -2, 5}, 0.7}, {-0.5, 0, -0.25}, {0.5, 2, 0.75}, 0, &facets);
  EXPECT_EQ(facets.size(), 6U);
  EXPECT_NEAR(enclosed_volume(facets), 2.0, 1e-9);
  expect_flat(facets);
}

// A frustum over a regular 12-gon; the 12-gon of circumradius r has the area 3 r^2.
TEST(ShapesTest, RodIsAClosedFrustumInAnyDirection) {
  HashRandom random(2);
  for (int i = 0; i < 50; ++i) {
    std::vector<Facet> facets;
    const Vector3d axis =
        direction_from_angles({random.uniform(-kPi, kPi), random.uniform(-kHalfPi, kHalfPi)});
    add_rod({{1, 2, 3}, random.uniform(-3, 3)}, {{0, 0, 0}, 2.0 * axis, 0.1, 0.2}, 0, &facets);
    const double expected = 2.0 / 3.0 * 3.0 * (0.1 * 0.1 + 0.1 * 0.2 + 0.2 * 0.2);
    EXPECT_NEAR(enclosed_volume(facets), expected, 1e-9);
    expect_flat(facets);
  }
}

TEST(ShapesTest, GlobeIsClosedAndRound) {
  std::vector<Facet> facets;
  add_globe({1, 2, 3}, 0.5, 0.4, 0, &facets);
  const double ellipsoid = 4.0 / 3.0 * kPi * 0.5 * 0.5 * 0.4;
  EXPECT_NEAR(enclosed_volume(facets), ellipsoid, 0.02 * ellipsoid);
  expect_flat(facets);
}

// Seen from the front, s runs to the right and t upwards.
TEST(ShapesTest, PanelsFaceTheRoomWithUprightTextures) {
  std::vector<Facet> facets;
  add_panel({{0, 0, 2}, kPi}, {-1, 0, 0}, {1, 1, 0.1}, 0, &facets);  // faces -z
  EXPECT_EQ(facets.size(), 5U) << "no back";
  expect_flat(facets);
  const Facet& front = facets.front();
  EXPECT_LT((front.normal - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((front.texture.s_axis - Vector3d(1, 0, 0)).norm(), 1e-12);
  const auto& c = front.corners;
  const Facet quad = make_quad({c[0], c[1], c[2], c[3]}, 0);
  EXPECT_LT((quad.normal - front.normal).norm(), 1e-12);
  EXPECT_LT((quad.texture.t_axis - front.texture.t_axis).norm(), 1e-12);
}

// --- Randomness and patterns ---------------------------------------------------------------------

TEST(HashRandomTest, BranchesDoNotDependOnPreviousDraws) {
  HashRandom a(1), b(1);
  a.bits();
  EXPECT_EQ(a.branch(3).bits(), b.branch(3).bits());
  EXPECT_NE(b.branch(3).bits(), b.branch(4).bits());
}

// Known values keep rooms the same from release to release.
TEST(HashRandomTest, HashIsSplitMix64) {
  EXPECT_EQ(hash_bits(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(hash_bits(0x9e3779b97f4a7c15ULL), 0x6e789e6aa1b965f4ULL);
}

TEST(NoiseTest, OctavesBeyondTheNyquistLimitFadeOut) {
  const Octaves octaves{1.0F, 6, 0.7F};
  double sharp = 0.0, blurred = 0.0, constant = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector2f here(0.173F * static_cast<float>(i), 0.41F);
    const Eigen::Vector2f near = here + Eigen::Vector2f(0.03F, 0.0F);
    sharp +=
        std::abs(fractal_noise(here, octaves, 0.001F, 1) - fractal_noise(near, octaves, 0.001F, 1));
    blurred +=
        std::abs(fractal_noise(here, octaves, 0.4F, 1) - fractal_noise(near, octaves, 0.4F, 1));
    constant += std::abs(fractal_noise(here, octaves, 1.1F, 1));
  }
  EXPECT_LT(blurred, 0.3 * sharp);
  EXPECT_EQ(constant, 0.0);
}

TEST(NoiseTest, StripeKeepsItsAreaBelowPixelSize) {
  for (const float footprint : {0.01F, 0.1F, 0.5F, 2.0F}) {
    double area = 0.0;
    for (int i = -3000; i < 3000; ++i) {
      area += 0.001 * soft_stripe(0.001F * static_cast<float>(i), 0.1F, footprint);
    }
    EXPECT_NEAR(area, 0.2, 0.003) << footprint;
  }
}

TEST(SurfaceTest, ReflectancesArePositiveAndBounded) {
  HashRandom random(4);
  for (int pattern = 0; pattern <= static_cast<int>(Pattern::kPainting); ++pattern) {
    Surface surface;
    surface.pattern = static_cast<Pattern>(pattern);
    surface.base = Color(0.6F, 0.5F, 0.4F);
    surface.accent = Color(0.2F, 0.3F, 0.4F);
    surface.seed = 9;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2f at(static_cast<float>(random.uniform(-20, 20)),
                               static_cast<float>(random.uniform(-20, 20)));
      const Color albedo =
          albedo_at(surface, at, static_cast<float>(1e-4 * std::pow(1e4, random.uniform())));
      EXPECT_GT(albedo.minCoeff(), 0.0F) << pattern;
      EXPECT_LT(albedo.maxCoeff(), 1.3F) << pattern;
    }
  }
}

}  // namespace
}  // namespace raywalk::simulator
