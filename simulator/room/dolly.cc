#include "simulator/room/dolly.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/panorama/srgb.h"
#include "simulator/room/color.h"
#include "simulator/room/noise.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRaysPerSide = 4;
// Upper bound of the dolly's elevation: the corners of the largest platform (reach 45 degrees) are
// sqrt(2) times as far out as its edges, 35 degrees below the horizon.
constexpr double kHighestSine = -0.5;
constexpr double kFar = std::numeric_limits<double>::infinity();

// Intersection of a ray with the dolly.
struct DollyHit {
  double distance = kFar;
  Vector3d normal{0, 1, 0};
  Vector2d on_surface{0, 0};  // for the texture
};

// Keeps the nearer hit; returns whether `hit` was kept.
bool keep_nearer(const DollyHit& hit, DollyHit* nearest) {
  if (!(hit.distance > 0.0 && hit.distance < nearest->distance)) return false;
  *nearest = hit;
  return true;
}

struct Box {
  Vector3d min{0, 0, 0};
  Vector3d max{0, 0, 0};
};

// The slab method (Kay and Kajiya 1986): the ray is inside the box while it is between all three
// pairs of faces. The camera is outside, so the ray enters at the last of the three entry faces.
DollyHit intersect(const Box& box, const CameraRay& ray) {
  double enters = 0.0, leaves = kFar;
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double at_min = (box.min[axis] - ray.origin_m[axis]) / ray.direction[axis];
    const double at_max = (box.max[axis] - ray.origin_m[axis]) / ray.direction[axis];
    const double near = std::min(at_min, at_max);
    if (near > enters) {
      enters = near;
      face = axis;
    }
    leaves = std::min(leaves, std::max(at_min, at_max));
  }
  if (face < 0 || enters >= leaves) return {};
  DollyHit hit;
  hit.distance = enters;
  hit.normal = Vector3d::Zero();
  hit.normal[face] = ray.direction[face] > 0.0 ? -1.0 : 1.0;
  const Vector3d at = ray.origin_m + enters * ray.direction;
  hit.on_surface = {at[(face + 1) % 3], at[(face + 2) % 3]};
  return hit;
}

// A cylinder along one axis of the frame, with its two ends.
struct Cylinder {
  int axis = 1;
  Vector3d centre{0, 0, 0};
  double radius = 0.0;
  double half_length = 0.0;
};

DollyHit intersect_mantle(const Cylinder& cylinder, const CameraRay& ray) {
  const int a = (cylinder.axis + 1) % 3, b = (cylinder.axis + 2) % 3;
  const Vector3d from = ray.origin_m - cylinder.centre;
  const Vector2d start(from[a], from[b]), step(ray.direction[a], ray.direction[b]);
  const double square = step.squaredNorm(), half = start.dot(step);
  const double root =
      half * half - square * (start.squaredNorm() - cylinder.radius * cylinder.radius);
  if (square == 0.0 || root < 0.0) return {};
  DollyHit hit;
  hit.distance = (-half - std::sqrt(root)) / square;
  const double along = from[cylinder.axis] + hit.distance * ray.direction[cylinder.axis];
  if (std::abs(along) > cylinder.half_length) return {};
  const Vector2d around = (start + hit.distance * step) / cylinder.radius;
  hit.normal = Vector3d::Zero();
  hit.normal[a] = around.x();
  hit.normal[b] = around.y();
  hit.on_surface = {along, cylinder.radius * std::atan2(around.y(), around.x())};
  return hit;
}

DollyHit intersect_ends(const Cylinder& cylinder, const CameraRay& ray) {
  const double slope = ray.direction[cylinder.axis];
  const double side = slope > 0.0 ? -1.0 : 1.0;  // of the end that faces the ray
  const Vector3d from = ray.origin_m - cylinder.centre;
  DollyHit hit;
  hit.distance = (side * cylinder.half_length - from[cylinder.axis]) / slope;
  const Vector3d at = from + hit.distance * ray.direction;
  hit.on_surface = {at[(cylinder.axis + 1) % 3], at[(cylinder.axis + 2) % 3]};
  if (!(hit.on_surface.squaredNorm() <= cylinder.radius * cylinder.radius)) return {};
  hit.normal = Vector3d::Zero();
  hit.normal[cylinder.axis] = side;
  return hit;
}

DollyHit intersect(const Cylinder& cylinder, const CameraRay& ray) {
  DollyHit nearest;
  keep_nearer(intersect_mantle(cylinder, ray), &nearest);
  keep_nearer(intersect_ends(cylinder, ray), &nearest);
  return nearest;
}

enum class Finish { kSteel, kWood, kRubber, kAluminium };

Color paint(Finish finish, const Vector2d& at) {
  const Eigen::Vector2f place = at.cast<float>();
  // Scratches and dirt, scaled with the dolly.
  const float dirt = 1.0F + 0.25F * fractal_noise(place, {0.08F, 4, 0.6F}, 0.002F, 71U);
  switch (finish) {
    case Finish::kSteel:
      return dirt * Color(0.10F, 0.11F, 0.13F);
    case Finish::kRubber:
      return dirt * Color(0.03F, 0.03F, 0.03F);
    case Finish::kAluminium:
      return dirt * Color(0.45F, 0.46F, 0.48F);
    case Finish::kWood:
      break;
  }
  // Planks across the platform, each of its own shade.
  constexpr float kPlank = 0.09F;
  const float across = place.y() / kPlank;
  const float shade = 0.75F + 0.5F * cell_value(static_cast<int>(std::floor(across)), 0, 72U);
  const bool gap = across - std::floor(across) < 0.06F;
  const float grain =
      1.0F + 0.3F * fractal_noise({0.2F * place.x(), place.y()}, {0.03F, 4, 0.6F}, 0.002F, 73U);
  return (gap ? 0.25F : shade * grain) * dirt * Color(0.36F, 0.20F, 0.09F);
}

template <typename Shape>
struct Part {
  Shape shape;
  Finish finish;
};

// In the camera's frame, in units of the floor's distance.
class Dolly {
 public:
  explicit Dolly(double reach_rad) {
    constexpr double kTop = -0.86, kBottom = -0.90, kWheelRadius = 0.05, kRailTop = -0.97;
    constexpr double kPlate = 0.055;  // hides a little more than the pole
    const double half = -kTop * std::tan(reach_rad);
    cylinders_.push_back(
        {{1, {0, -0.105, 0}, kPlate * std::tan(reach_rad), 0.005}, Finish::kSteel});
    cylinders_.push_back({{1, {0, -0.485, 0}, 0.018, 0.375}, Finish::kAluminium});
    boxes_.push_back({{{-half, kBottom, -half}, {half, kTop, half}}, Finish::kWood});
    boxes_.push_back({{{-0.06, -1.0, -1.1 * half}, {0.06, kRailTop, 1.1 * half}}, Finish::kSteel});
    for (const double x : {-half, half}) {
      for (const double z : {-0.7 * half, 0.7 * half}) {
        cylinders_.push_back(
            {{0, {x, -1.0 + kWheelRadius, z}, kWheelRadius, 0.03}, Finish::kRubber});
      }
    }
  }

  // The light along a ray; empty if it misses the dolly.
  std::optional<Color> look(const CameraRay& ray) const {
    DollyHit nearest;
    Finish finish = Finish::kSteel;
    const auto consider = [&](const auto& parts) {
      for (const auto& part : parts) {
        if (keep_nearer(intersect(part.shape, ray), &nearest)) finish = part.finish;
      }
    };
    consider(boxes_);
    consider(cylinders_);
    if (nearest.distance == kFar) return std::nullopt;
    // From the ceiling, and a little more from the front right.
    const double from_side = nearest.normal.dot(Vector3d(0.6, 0.0, 0.8));
    const double lit = 0.4 + 0.5 * std::max(nearest.normal.y(), 0.0) + 0.15 * from_side;
    return static_cast<float>(lit) * paint(finish, nearest.on_surface);
  }

 private:
  std::vector<Part<Box>> boxes_;
  std::vector<Part<Cylinder>> cylinders_;
};

// The part of a pixel that the dolly covers.
struct Cover {
  int rays = 0;
  Color light{0, 0, 0};
};

class CoverFinder {
 public:
  CoverFinder(const PixelRays& camera, const Dolly& dolly, double floor_m)
      : camera_(camera), dolly_(dolly), floor_m_(floor_m) {}

  Cover of_pixel(int row, int column) const {
    Cover cover;
    if (!looks_down(row, column)) return cover;
    constexpr int kStep = kPixelParts / kRaysPerSide;
    for (int v = kStep / 2; v < kPixelParts; v += kStep) {
      for (int u = kStep / 2; u < kPixelParts; u += kStep) {
        const auto ray = camera_.at_part(column * kPixelParts + u, row * kPixelParts + v);
        if (!ray) continue;
        const auto light = dolly_.look({ray->origin_m / floor_m_, ray->direction});
        if (!light) continue;
        ++cover.rays;
        cover.light += *light;
      }
    }
    return cover;
  }

 private:
  // Tests the four corner parts, so that a pixel on the edge of an image circle is not missed.
  bool looks_down(int row, int column) const {
    for (const int v : {0, kPixelParts - 1}) {
      for (const int u : {0, kPixelParts - 1}) {
        const auto ray = camera_.at_part(column * kPixelParts + u, row * kPixelParts + v);
        if (ray && ray->direction.y() < kHighestSine) return true;
      }
    }
    return false;
  }

  const PixelRays& camera_;
  const Dolly& dolly_;
  double floor_m_;
};

}  // namespace

DollyView::DollyView(const PixelRays& camera, const DollySettings& settings, double floor_m)
    : share_(cv::Mat::zeros(camera.height(), camera.width(), CV_32FC1)),
      light_(cv::Mat::zeros(camera.height(), camera.width(), CV_32FC3)) {
  if (!(floor_m > 0.0)) throw Error("the camera on a dolly must be above the floor");
  const Dolly dolly(radians_from_degrees(settings.reach_deg));
  const CoverFinder finder(camera, dolly, floor_m);
  parallel_for(0, share_.rows, 4, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < share_.cols; ++column) {
        const Cover cover = finder.of_pixel(row, column);
        constexpr float kEach = 1.0F / (kRaysPerSide * kRaysPerSide);
        const Color light = kEach * cover.light;
        share_.at<float>(row, column) = kEach * static_cast<float>(cover.rays);
        light_.at<cv::Vec3f>(row, column) = {light[2], light[1], light[0]};
      }
    }
  });
}

void DollyView::cover(cv::Mat* picture) const {
  if (picture->type() != CV_8UC3 || picture->size() != share_.size()) {
    throw Error("the dolly was rendered for pictures of another size or type");
  }
  parallel_for(0, picture->rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < picture->cols; ++column) {
        const double share = share_.at<float>(row, column);
        if (share == 0.0) continue;
        auto& pixel = picture->at<cv::Vec3b>(row, column);
        const auto& light = light_.at<cv::Vec3f>(row, column);
        for (int channel = 0; channel < 3; ++channel) {
          const double mixed =
              (1.0 - share) * linear_from_srgb_level(pixel[channel]) + light[channel];
          pixel[channel] =
              static_cast<unsigned char>(std::lround(srgb_level_from_linear(std::min(mixed, 1.0))));
        }
      }
    }
  });
}

}  // namespace raywalk::capture
