#include "simulator/room/virtual_room.h"

#include <fmt/format.h>

#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "simulator/room/camera_clearance.h"
#include "simulator/room/eye_rays.h"
#include "simulator/room/hall.h"
#include "simulator/room/street_canyon.h"

namespace raywalk::capture {
namespace {

RoomPlan plan_of(const VirtualRoomSettings& settings) {
  if (settings.place == "canyon") return plan_canyon(settings);
  if (settings.place == "hall") return plan_hall(settings);
  return plan_room(settings);
}

void require_panorama(PanoramaSize size) {
  if (size.height < 1 || size.width != 2 * size.height) {
    throw Error("a panorama of the virtual room must be twice as wide as high");
  }
}

// Nothing is nearer to a station than the clearance, so the ring's cameras are free as well.
void require_ring_within(const RoomPlan& plan, const RingSettings& ring) {
  const double clearance_mm = 1e3 * plan.unit_m * plan.clearance;
  if (ring.radius_mm < clearance_mm) return;
  throw UsageError(fmt::format(
      "ring.radius_mm is {:g}; it must be less than the {:g} mm that are free around the stations",
      ring.radius_mm, clearance_mm));
}

// The rays through the centres of a panorama's pixels, room units.
class CentreRays {
 public:
  CentreRays(const CameraPose& pose, PanoramaSize size, double unit_m)
      : origin_(pose.position_m / unit_m),
        rotation_(world_from_camera(pose.attitude)),
        size_(size) {}

  std::vector<Ray> row(int v) const {
    std::vector<Ray> rays(static_cast<std::size_t>(size_.width));
    for (int u = 0; u < size_.width; ++u) {
      const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
      rays[static_cast<std::size_t>(u)] = {
          origin_, rotation_ * direction_from_angles(angles_from_pixel(pixel, size_))};
    }
    return rays;
  }

 private:
  Eigen::Vector3d origin_;
  Eigen::Matrix3d rotation_;
  PanoramaSize size_;
};

}  // namespace

VirtualRoom::VirtualRoom(const VirtualRoomSettings& settings)
    : settings_(settings),
      plan_(plan_of(settings)),
      film_{static_cast<float>(settings.light.exposure),
            settings.light.clip ? Highlights::kClipped : Highlights::kSoft},
      scene_(std::make_unique<const RoomScene>(plan_, settings)) {
  require_clear_lines(plan_, *scene_);
  require_ring_within(plan_, settings.ring);
  if (settings.people.count > 0) {
    people_ = std::make_unique<const PeoplePath>(plan_, scene_->geometry(), settings.people);
  }
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
  return render_picture(*scene_, PanoramaRays(size), pose, plan_.unit_m, sampling, film_);
}

cv::Mat VirtualRoom::stereo_panorama(const Eigen::Vector3d& position_m, double eyes_apart_m,
                                     PanoramaSize size, Sampling sampling) const {
  require_panorama(size);
  require_free_camera(plan_, *scene_, position_m);
  cv::Mat both;
  for (const double radius_m : {0.5 * eyes_apart_m, -0.5 * eyes_apart_m}) {
    both.push_back(render_picture(*scene_, EyeRays(size, radius_m), {position_m, {}}, plan_.unit_m,
                                  sampling, film_));
  }
  return both;
}

cv::Mat VirtualRoom::panorama_with_people(int moment, const CameraPose& pose, PanoramaSize size,
                                          Sampling sampling) const {
  require_panorama(size);
  return picture_with_people(moment, PanoramaRays(size), pose, sampling);
}

cv::Mat VirtualRoom::picture_with_people(int moment, const PixelRays& camera,
                                         const CameraPose& pose, Sampling sampling) const {
  require_free_camera(plan_, *scene_, pose.position_m);
  const std::optional<PeopleScene> people = people_at(moment);
  return render_picture(*scene_, camera, pose, plan_.unit_m, sampling, film_,
                        people ? &*people : nullptr);
}

cv::Mat VirtualRoom::people_mask(int moment, const CameraPose& pose, PanoramaSize size) const {
  require_panorama(size);
  require_free_camera(plan_, *scene_, pose.position_m);
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(0));
  const std::optional<PeopleScene> people = people_at(moment);
  if (!people) return mask;
  const CentreRays centres(pose, size, plan_.unit_m);
  parallel_for(0, size.height, 8, [&](int begin, int end) {
    std::vector<double> distances(static_cast<std::size_t>(size.width));
    std::vector<Hit> persons(distances.size());
    for (int v = begin; v < end; ++v) {
      const std::vector<Ray> rays = centres.row(v);
      scene_->measure(rays, distances);
      people->intersect(rays, persons);
      for (std::size_t u = 0; u < rays.size(); ++u) {
        const bool seen = persons[u].facet >= 0 && persons[u].distance < distances[u];
        if (seen) mask.at<uchar>(v, static_cast<int>(u)) = 255;
      }
    }
  });
  return mask;
}

std::optional<PeopleScene> VirtualRoom::people_at(int moment) const {
  if (!people_) return std::nullopt;
  return std::optional<PeopleScene>(std::in_place, people_->at(moment), settings_.seed);
}

cv::Mat VirtualRoom::distance_map(const CameraPose& pose, PanoramaSize size) const {
  require_panorama(size);
  require_free_camera(plan_, *scene_, pose.position_m);
  const CentreRays centres(pose, size, plan_.unit_m);
  cv::Mat map(size.height, size.width, CV_32FC1);
  parallel_for(0, size.height, 8, [&](int begin, int end) {
    std::vector<double> distances(static_cast<std::size_t>(size.width));
    for (int v = begin; v < end; ++v) {
      scene_->measure(centres.row(v), distances);
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
  return render_picture(*scene_, DualFisheyeRays(layout, frame), pose, plan_.unit_m, sampling,
                        film_);
}

}  // namespace raywalk::capture
