#include "simulator/room/virtual_room.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/shipped_configs.h"
#include "simulator/room/bodies.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

RoomExtent extent_of(const Facets& room, const Vector3d& middle_m) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  RoomExtent extent{Vector3d::Constant(kFar), Vector3d::Constant(-kFar)};
  for (const Facet& facet : room.facets) {
    for (const Vector3d& corner : facet.corners) {
      extent.min_m = extent.min_m.cwiseMin(corner - middle_m);
      extent.max_m = extent.max_m.cwiseMax(corner - middle_m);
    }
  }
  return extent;
}

// Calls pixel(v, u, ray) for every pixel of a panorama, with the ray through its centre, in
// parallel.
template <typename Pixel>
void for_each_pixel(const CameraPose& in_scene, PanoramaSize size, const Pixel& pixel) {
  if (size.height < 1 || size.width != 2 * size.height) {
    throw Error("a panorama of the virtual room must be twice as wide as high");
  }
  const Eigen::Matrix3d rotation = world_from_camera(in_scene.attitude);
  parallel_for(0, size.height, 8, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const PixelPosition centre{static_cast<double>(u), static_cast<double>(v)};
        const Vector3d direction = direction_from_angles(angles_from_pixel(centre, size));
        pixel(v, u, Ray{in_scene.position_m, rotation * direction});
      }
    }
  });
}

// Adds the facets in another frame, with their surfaces.
void add_moved(const std::vector<Facet>& facets, const std::vector<Surface>& surfaces,
               const Eigen::Matrix3d& rotation, const Vector3d& origin, Facets* to) {
  const auto first = static_cast<int>(to->surfaces.size());
  to->surfaces.insert(to->surfaces.end(), surfaces.begin(), surfaces.end());
  for (const Facet& facet : facets) {
    to->facets.push_back(moved(facet, rotation, origin));
    to->facets.back().surface += first;
  }
}

}  // namespace

VirtualRoom::VirtualRoom(const VirtualRoomSettings& settings)
    : VirtualRoom(settings, read_scene(named_config(settings.scene.file, ConfigKind::kScene,
                                                    "the scene, 'scene.file',"))) {}

VirtualRoom::VirtualRoom(const VirtualRoomSettings& settings, Scene scene)
    : settings_(settings),
      scene_(std::move(scene)),
      solids_(scene_.room.facets),
      light_map_(scene_.room, solids_, scene_.lights),
      extent_(extent_of(scene_.room, settings.scene.middle_m)) {
  if (!scene_.glass.empty()) glass_.emplace(scene_.glass);
}

CameraPose VirtualRoom::in_scene(const CameraPose& pose) const {
  return {pose.position_m + settings_.scene.middle_m, pose.attitude};
}

void VirtualRoom::require_free(const Vector3d& position_m) const {
  const auto refuse = [&](const char* what) {
    throw Error(fmt::format("scene {}: the camera at ({:g}, {:g}, {:g}) m {}",
                            settings_.scene.file.string(), position_m.x(), position_m.y(),
                            position_m.z(), what));
  };
  if (!position_m.allFinite()) refuse("has no finite position");
  const bool is_within = (position_m.array() > extent_.min_m.array()).all() &&
                         (position_m.array() < extent_.max_m.array()).all();
  if (!is_within) refuse("is outside the room");
  if (is_inside_solid(position_m + settings_.scene.middle_m)) {
    refuse("is inside furniture; move it, or the grid (scene.x_m, y_m and z_m)");
  }
}

bool VirtualRoom::is_free(const Vector3d& position_m, double around_m) const {
  constexpr int kLooks = 32;
  try {
    require_free(position_m);
  } catch (const Error&) {
    return false;
  }
  for (int i = 0; i < kLooks; ++i) {
    const Vector3d level = direction_from_angles({kTwoPi * i / kLooks - kPi, 0.0});
    const Ray ray{position_m + settings_.scene.middle_m, level};
    if (solids_.occluded(ray, around_m)) return false;
  }
  return true;
}

std::unique_ptr<const Bodies> VirtualRoom::bodies_of(const RenderOptions& options,
                                                     const CameraPose& pose) const {
  Facets bodies;
  if (options.station >= 0) {
    for (const MovingObject& object : scene_.moving) {
      const Placement place = object.at(options.station);
      add_moved(object.facets, scene_.room.surfaces, place.rotation(), place.origin, &bodies);
    }
  }
  const std::size_t moving = bodies.facets.size();
  if (options.carried != nullptr) {
    add_moved(options.carried->facets, options.carried->surfaces, world_from_camera(pose.attitude),
              pose.position_m, &bodies);
  }
  return bodies.facets.empty() ? nullptr
                               : std::make_unique<const Bodies>(std::move(bodies), moving);
}

cv::Mat VirtualRoom::moving_mask(int station, const CameraPose& pose, PanoramaSize size) const {
  require_free(pose.position_m);
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(0));
  const std::unique_ptr<const Bodies> bodies = bodies_of({.station = station}, in_scene(pose));
  if (!bodies) return mask;
  for_each_pixel(in_scene(pose), size, [&](int v, int u, const Ray& ray) {
    const Hit hit = bodies->intersect(ray);
    if (hit.facet >= 0 && hit.distance < measure(ray)) mask.at<uchar>(v, u) = 255;
  });
  return mask;
}

cv::Mat VirtualRoom::distance_map(const CameraPose& pose, PanoramaSize size) const {
  require_free(pose.position_m);
  cv::Mat map(size.height, size.width, CV_32FC1);
  for_each_pixel(in_scene(pose), size, [&](int v, int u, const Ray& ray) {
    map.at<float>(v, u) = static_cast<float>(measure(ray));
  });
  return map;
}

}  // namespace raywalk::simulator
