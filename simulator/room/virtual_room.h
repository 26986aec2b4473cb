// A virtual furnished room, seen by simulated cameras: a scene with known ground truth.
//
// Frames and pixels are those of core/geometry/sphere.h: metres, x right, y up, z forward; the
// origin is the middle of the capture grid at the height of its lines. Lighting is view-independent
// (diffuse surfaces, precomputed irradiance), except for one mirror. The same settings give the
// same bytes with any number of threads; a room with another cell side is the same room at another
// scale.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "simulator/room/camera_pose.h"
#include "simulator/room/dual_fisheye.h"
#include "simulator/room/picture_renderer.h"
#include "simulator/room/room_plan.h"
#include "simulator/room/room_settings.h"
#include "simulator/room/walking_people.h"

namespace raywalk::capture {

// The inside of the room, metres in the world frame.
struct RoomExtent {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

// Thread-safe.
class VirtualRoom {
 public:
  // Furnishes and lights the room, which takes about a second. Throws UsageError naming key or seed
  // if the room is too small for its grid, contents or people, Error if an object is closer to a
  // line than a quarter of the cell's side or the ray tracer fails; Interrupted.
  explicit VirtualRoom(const VirtualRoomSettings& settings);
  ~VirtualRoom();

  const VirtualRoomSettings& settings() const { return settings_; }
  const RoomPlan& plan() const { return plan_; }
  RoomExtent extent() const;

  // The functions below throw Error naming pose and seed if the camera is outside the room or
  // inside an object, and Interrupted.

  // The panorama, BGR in CV_8UC3, noise-free. The size must be 2:1.
  cv::Mat panorama(const CameraPose& pose, PanoramaSize size,
                   Sampling sampling = Sampling::kFine) const;

  // Omnidirectional stereo (core/geometry/eye_circle.h) around the position of a camera that is not
  // turned: the panorama of the left eye above that of the right one, each of `size`.
  cv::Mat stereo_panorama(const Eigen::Vector3d& position_m, double eyes_apart_m, PanoramaSize size,
                          Sampling sampling = Sampling::kFine) const;

  // The panorama with the people of settings().people where they are while station `moment` (0 =
  // the first) is captured.
  cv::Mat panorama_with_people(int moment, const CameraPose& pose, PanoramaSize size,
                               Sampling sampling = Sampling::kFine) const;

  // The same through another camera. Several cameras may be at the station: only the pose's
  // position is checked.
  cv::Mat picture_with_people(int moment, const PixelRays& camera, const CameraPose& pose,
                              Sampling sampling = Sampling::kFine) const;

  // CV_8UC1: 255 where the ray through a pixel's centre meets one of those people, else 0.
  cv::Mat people_mask(int moment, const CameraPose& pose, PanoramaSize size) const;

  // Metres along the ray through each pixel's centre to the first surface of the room without
  // people, CV_32FC1; +inf for the sky, seen through the window. A pane of glass is looked through:
  // the distance is that to what is behind it. The distance to the mirror is that
  // to its surface.
  cv::Mat distance_map(const CameraPose& pose, PanoramaSize size) const;

  // A frame with two image circles, BGR in CV_8UC3, black around them. The pose is that of the
  // layout's camera frame. Also throws Error for an invalid lens (see DualFisheyeRays).
  cv::Mat dual_fisheye(const CameraPose& pose, const DualFisheyeLayout& layout, PanoramaSize frame,
                       Sampling sampling = Sampling::kFine) const;

 private:
  std::optional<PeopleScene> people_at(int moment) const;

  VirtualRoomSettings settings_;
  RoomPlan plan_;
  Film film_;
  std::unique_ptr<const RoomScene> scene_;
  std::unique_ptr<const PeoplePath> people_;  // null: nobody
};

}  // namespace raywalk::capture
