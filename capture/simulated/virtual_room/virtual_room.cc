#include "capture/simulated/virtual_room/virtual_room.h"

#include <vector>

#include "capture/simulated/virtual_room/camera_clearance.h"
#include "core/base/error.h"
#include "core/base/parallel.h"

namespace raywalk::capture {
namespace {

void require_panorama(PanoramaSize size) {
  if (size.height < 1 || size.width != 2 * size.height) {
    throw Error("a panorama of the virtual room must be twice as wide as high");
  }
}

}  // namespace

VirtualRoom::VirtualRoom(const VirtualRoomSettings& settings)
    : settings_(settings),
      plan_(plan_room(settings)),
      scene_(std::make_unique<const RoomScene>(plan_, settings.contents)) {
  require_clear_lines(plan_, *scene_);
}

VirtualRoom::~VirtualRoom() = default;

RoomExtent VirtualRoom::extent() const {
  const RoomBox& box = plan_.walls;
  return {plan_.unit_m * Eigen::Vector3d(box.x_min, box.y_min, box.z_min),
          plan_.unit_m * Eigen::Vector3d(box.x_max, box.y_max, box.z_max)};
}

cv::Mat VirtualRoom::panorama(const CameraPose& pose, PanoramaSize size, Sampling sampling) const {
  require_panorama(size);
  require_free_camera(plan_, *scene_, pose.position_m);
  return render_picture(*scene_, PanoramaRays(size), pose, plan_.unit_m, sampling);
}

cv::Mat VirtualRoom::distance_map(const CameraPose& pose, PanoramaSize size) const {
  require_panorama(size);
  require_free_camera(plan_, *scene_, pose.position_m);
  const Eigen::Matrix3d rotation = world_from_camera(pose.attitude);
  cv::Mat map(size.height, size.width, CV_32FC1);
  parallel_for(0, size.height, 8, [&](int begin, int end) {
    std::vector<Ray> rays(static_cast<std::size_t>(size.width));
    std::vector<double> distances(rays.size());
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
        rays[static_cast<std::size_t>(u)] = {
            pose.position_m / plan_.unit_m,
            rotation * direction_from_angles(angles_from_pixel(pixel, size))};
      }
      scene_->measure(rays, distances);
      for (int u = 0; u < size.width; ++u) {
        map.at<float>(v, u) =
            static_cast<float>(plan_.unit_m * distances[static_cast<std::size_t>(u)]);
      }
    }
  });
  return map;
}

cv::Mat VirtualRoom::dual_fisheye(const CameraPose& pose, const DualFisheyeLayout& layout,
                                  PanoramaSize frame, Sampling sampling) const {
  require_free_camera(plan_, *scene_, pose.position_m);
  return render_picture(*scene_, DualFisheyeRays(layout, frame), pose, plan_.unit_m, sampling);
}

}  // namespace raywalk::capture
