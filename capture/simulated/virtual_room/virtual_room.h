// A furnished room that exists only in the computer, seen by simulated cameras: ground truth for
// everything that has to be tried on a scene whose truth is known.
//
// Frames and pixels are those of core/geometry/sphere.h: metres, x right, y up, z forward; the
// origin is the middle of the capture grid at the height of its lines. The room is lit the same
// from every viewpoint (matt surfaces, light computed once) but for one mirror. Everything follows
// from the settings: the same settings give the same bytes, whatever the number of threads; a room
// of another cell side is the same room at another scale.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "capture/simulated/virtual_room/camera_pose.h"
#include "capture/simulated/virtual_room/dual_fisheye.h"
#include "capture/simulated/virtual_room/picture_renderer.h"
#include "capture/simulated/virtual_room/room_plan.h"
#include "capture/simulated/virtual_room/room_settings.h"

namespace raywalk::capture {

// The inside of the room, metres in the world frame.
struct RoomExtent {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

// Safe to use from several threads at once.
class VirtualRoom {
 public:
  // Furnishes and lights the room, which takes about a second. Throws UsageError naming key or seed
  // where the room is too small for its grid or its contents, and Error where something stands
  // closer to a line than a quarter of the cell's side or the ray tracer fails; Interrupted.
  explicit VirtualRoom(const VirtualRoomSettings& settings);
  ~VirtualRoom();

  const VirtualRoomSettings& settings() const { return settings_; }
  const RoomPlan& plan() const { return plan_; }
  RoomExtent extent() const;

  // The three below throw Error naming pose and seed where the camera is outside of the room or
  // inside of something in it, and Interrupted.

  // The panorama, BGR in CV_8UC3, noise-free. The size must be 2:1.
  cv::Mat panorama(const CameraPose& pose, PanoramaSize size,
                   Sampling sampling = Sampling::kFine) const;

  // Metres along the ray through each pixel's centre to the first surface, CV_32FC1; +inf for the
  // sky, to which the window's clear glass is looked through. The mirror counts at its own surface.
  cv::Mat distance_map(const CameraPose& pose, PanoramaSize size) const;

  // A frame of two image circles, BGR in CV_8UC3, black around them. The pose is that of the
  // layout's camera frame. Throws Error also for a lens that cannot be (see DualFisheyeRays).
  cv::Mat dual_fisheye(const CameraPose& pose, const DualFisheyeLayout& layout, PanoramaSize frame,
                       Sampling sampling = Sampling::kFine) const;

 private:
  VirtualRoomSettings settings_;
  RoomPlan plan_;
  std::unique_ptr<const RoomScene> scene_;
};

}  // namespace raywalk::capture
