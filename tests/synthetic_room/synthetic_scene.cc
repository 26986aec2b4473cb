#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/base/parallel.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

constexpr double kMeanLevel = 128.0;
constexpr double kAmplitude = 90.0;
constexpr int kChannels = 3;
constexpr int kWavesPerChannel = 3;
constexpr double kSkyRadius_m = 2.0;  // of the sphere with the sky's texture
constexpr int kRowsPerTask = 8;

struct Interval {
  double enter = 0.0;
  double leave = 0.0;
};

// The interval of a ray inside a box (slab method). A ray parallel to a plane gives 0 / 0 only if
// it starts on it; such a plane does not limit the interval.
Interval within_box(const SceneBox& box, const Eigen::Vector3d& origin_m,
                    const Eigen::Vector3d& direction) {
  Interval within{-std::numeric_limits<double>::infinity(),
                  std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    const double to_min = (box.min_m[axis] - origin_m[axis]) / direction[axis];
    const double to_max = (box.max_m[axis] - origin_m[axis]) / direction[axis];
    if (std::isnan(to_min) || std::isnan(to_max)) continue;
    within.enter = std::max(within.enter, std::min(to_min, to_max));
    within.leave = std::min(within.leave, std::max(to_min, to_max));
  }
  return within;
}

std::optional<double> distance_to_obstacle(const SyntheticScene& scene,
                                           const Eigen::Vector3d& origin_m,
                                           const Eigen::Vector3d& direction) {
  if (!scene.obstacle) return std::nullopt;
  const Interval within = within_box(*scene.obstacle, origin_m, direction);
  if (within.enter < 0.0 || within.enter > within.leave) return std::nullopt;
  return within.enter;
}

// The texture of one seed, as a function of the position in space, without seams at edges: each
// channel is the mean of waves cos(wave . point + phase), whose `wave` has 2 pi / wavelength
// radians per metre.
class Paint {
 public:
  Paint(unsigned seed, double wavelength_m) {
    std::mt19937 random(seed);  // portable, unlike the distributions of <random>
    const auto unit = [&] { return random() / static_cast<double>(std::mt19937::max()); };
    for (int i = 0; i < waves_.rows(); ++i) {
      const SphereAngles heading{kTwoPi * unit() - kPi, std::asin(2.0 * unit() - 1.0)};
      const double length_m = wavelength_m * (0.7 + 0.6 * unit());
      waves_.row(i) = direction_from_angles(heading) * (kTwoPi / length_m);
      phases_[i] = kTwoPi * unit();
    }
  }

  // Red, green and blue in [-1, 1].
  Eigen::Vector3d at(const Eigen::Vector3d& point_m) const {
    // Eigen takes four cosines of single precision at once, where they are not converted as well.
    const Radians radians = (waves_ * point_m + phases_).cast<float>();
    const Radians cosines = radians.cos();
    return cosines.reshaped(Eigen::fix<kWavesPerChannel>, Eigen::fix<kChannels>)
        .colwise()
        .mean()
        .transpose()
        .cast<double>();
  }

 private:
  static constexpr int kWaves = kChannels * kWavesPerChannel;
  using Radians = Eigen::Array<float, kWaves, 1>;
  Eigen::Matrix<double, kWaves, 3> waves_;
  Eigen::Vector<double, kWaves> phases_;
};

// The textures of a scene.
class PaintedScene {
 public:
  explicit PaintedScene(const SyntheticScene& scene)
      : scene_(scene),
        walls_(scene.seed, scene.texture_wavelength_m),
        obstacle_(scene.seed + scene.obstacle_seed_step, scene.texture_wavelength_m) {}

  Eigen::Vector3d color_at(const Eigen::Vector3d& origin_m,
                           const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d paint = paint_at(origin_m, direction);
    return Eigen::Vector3d::Constant(kMeanLevel) + scene_.contrast * kAmplitude * paint;
  }

 private:
  Eigen::Vector3d paint_at(const Eigen::Vector3d& origin_m,
                           const Eigen::Vector3d& direction) const {
    if (scene_.infinitely_far) return walls_.at(kSkyRadius_m * direction);
    if (const auto distance_m = distance_to_obstacle(scene_, origin_m, direction)) {
      return obstacle_.at(origin_m + *distance_m * direction);
    }
    return walls_.at(origin_m + within_box(scene_.walls, origin_m, direction).leave * direction);
  }

  const SyntheticScene& scene_;
  Paint walls_;
  Paint obstacle_;
};

}  // namespace

double distance_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction) {
  if (scene.infinitely_far) return std::numeric_limits<double>::infinity();
  const auto obstacle_m = distance_to_obstacle(scene, origin_m, direction);
  return obstacle_m ? *obstacle_m : within_box(scene.walls, origin_m, direction).leave;
}

Eigen::Vector3d color_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                         const Eigen::Vector3d& direction) {
  return PaintedScene(scene).color_at(origin_m, direction);
}

cv::Mat render_scene(const SyntheticScene& scene, const Eigen::Vector3d& origin_m, int width,
                     double gain) {
  return render_scene(scene, EyeCircle{origin_m}, width, gain);
}

cv::Mat render_scene(const SyntheticScene& scene, const EyeCircle& eye, int width, double gain) {
  const PaintedScene painted(scene);
  const PanoramaSize size{width, width / 2};
  cv::Mat image(size.height, size.width, CV_8UC3);
  parallel_for(0, size.height, kRowsPerTask, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
        const Eigen::Vector3d rgb = gain * painted.color_at(eye.position_m(angles.theta_rad),
                                                            direction_from_angles(angles));
        // cv::saturate_cast rounds.
        image.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(rgb[2]),
                                     cv::saturate_cast<uchar>(rgb[1]),
                                     cv::saturate_cast<uchar>(rgb[0])};
      }
    }
  });
  return image;
}

}  // namespace raywalk
