// A box-shaped room with painted walls, in closed form: every ray's distance and colour are known
// exactly, so that whatever is rendered from light fields of it can be compared with the truth.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk {

// An axis-aligned box of the world frame, metres.
struct SceneBox {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

struct SyntheticScene {
  // The room; cameras are inside it.
  SceneBox walls{{-2.5, -1.2, -2.2}, {2.4, 1.5, 2.6}};
  // Something that stands in the room and hides what is behind it; cameras are outside of it.
  std::optional<SceneBox> obstacle{};
  // Everything is painted on the sky instead: all distances are infinite, and a picture looks the
  // same from everywhere.
  bool infinitely_far = false;
  // The paint is a sum of waves about this long on the surface, different for each seed.
  double texture_wavelength_m = 1.0;
  // 1: grey levels 38 to 218. 0: everything is the same grey, 128.
  double contrast = 1.0;
  unsigned seed = 1;
};

// Distance along the ray from `origin_m` to the first surface, metres; +inf where everything is
// infinitely far. `direction` is a unit vector.
double distance_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction);

// Red, green and blue of what the ray meets, in 0..255 before rounding.
Eigen::Vector3d color_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                         const Eigen::Vector3d& direction);

// The panorama (BGR, CV_8UC3, width / 2 rows) seen from `origin_m`, sampled at the pixels' centres.
// Colours are multiplied by `gain`, as by another exposure.
cv::Mat render_scene(const SyntheticScene& scene, const Eigen::Vector3d& origin_m, int width,
                     double gain = 1.0);

}  // namespace raywalk
