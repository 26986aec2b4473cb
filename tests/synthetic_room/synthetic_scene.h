// An analytic box-shaped room with textured walls: distance and colour of every ray are known
// exactly, as ground truth for views rendered from its light fields.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/eye_circle.h"
#include "core/geometry/sphere.h"

namespace raywalk {

// An axis-aligned box of the world frame, metres.
struct SceneBox {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

struct SyntheticScene {
  // The room; cameras must be inside it.
  SceneBox walls{{-2.5, -1.2, -2.2}, {2.4, 1.5, 2.6}};
  // An occluding object in the room; cameras must be outside it.
  std::optional<SceneBox> obstacle{};
  // Renders a sky instead: all distances are infinite, and the picture is the same from everywhere.
  bool infinitely_far = false;
  // The texture is a sum of waves of about this wavelength, determined by the seed.
  double texture_wavelength_m = 1.0;
  // 1: grey levels 38 to 218. 0: uniform grey, 128.
  double contrast = 1.0;
  unsigned seed = 1;
  // Added to the seed for the obstacle, so that its edges are visible.
  unsigned obstacle_seed_step = 1;
};

// Distance along the ray from `origin_m` to the first surface in metres; +inf if the scene is
// infinitely far. `direction` is a unit vector.
double distance_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction);

// Colour (red, green, blue) along the ray, 0..255, not rounded.
Eigen::Vector3d color_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                         const Eigen::Vector3d& direction);

// The panorama (BGR, CV_8UC3, width / 2 rows) of an eye, sampled at pixel centres. Colours are
// multiplied by `gain`, which simulates a different exposure.
cv::Mat render_scene(const SyntheticScene& scene, const EyeCircle& eye, int width,
                     double gain = 1.0);
// The same from one place.
cv::Mat render_scene(const SyntheticScene& scene, const Eigen::Vector3d& origin_m, int width,
                     double gain = 1.0);

}  // namespace raywalk
