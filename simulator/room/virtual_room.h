// A virtual room, seen by simulated cameras: a scene with known ground truth.
//
// Frames and pixels are those of core/geometry/sphere.h: metres, x right, y up, z forward; the
// origin is the middle of the capture grid at the height of its lines. Lighting is view-independent
// (diffuse surfaces, precomputed irradiance), except for mirrors and panes of glass. The same
// settings give the same bytes with any number of threads.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "simulator/room/cameras.h"
#include "simulator/room/renderer.h"
#include "simulator/room/room_settings.h"
#include "simulator/room/scene_file.h"

namespace raywalk::simulator {

// The smallest box around everything in the room, metres in the world frame.
struct RoomExtent {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

struct RenderOptions {
  // Moving objects are where they are while this station is captured (0 = the first); -1: the room
  // without them, as true views show it.
  int station = -1;
  // Moves with the camera, in its frame, and is hidden by nothing in the room: a dolly.
  const Facets* carried = nullptr;
};

// Thread-safe.
class VirtualRoom {
 public:
  // Reads settings.scene.file and lights the scene, which takes about a second. Throws UsageError
  // if there is no such scene (read_scene), Error if the ray tracer fails, Interrupted.
  explicit VirtualRoom(const VirtualRoomSettings& settings);
  VirtualRoom(const VirtualRoomSettings& settings, Scene scene);

  const VirtualRoomSettings& settings() const { return settings_; }
  RoomExtent extent() const { return extent_; }
  bool has_moving_objects() const { return !scene_->scene().moving.empty(); }
  // Whether a camera may be there: in the room, not inside a solid, and with nothing nearer at its
  // height than `around_m`.
  bool is_free(const Eigen::Vector3d& position_m, double around_m) const;

  // The functions below throw Error naming the scene and the position if the camera is outside the
  // room or inside a solid, and Interrupted.

  // What the camera sees, BGR in CV_8UC3, noise-free.
  cv::Mat render(const PixelRays& camera, const CameraPose& pose,
                 const RenderOptions& options = {}) const;

  // CV_8UC1: 255 where the ray through a pixel's centre of the panorama meets a moving object.
  cv::Mat moving_mask(int station, const CameraPose& pose, PanoramaSize size) const;

  // Metres along the ray through each pixel's centre of the panorama to the first surface of the
  // room without moving objects, CV_32FC1; +inf for the sky. A pane of glass is looked through: the
  // distance is that to what is behind it. The distance to a mirror is that to its surface.
  cv::Mat distance_map(const CameraPose& pose, PanoramaSize size) const;

 private:
  CameraPose in_scene(const CameraPose& pose) const;
  void require_free(const Eigen::Vector3d& position_m) const;
  std::unique_ptr<const Bodies> bodies_of(const RenderOptions& options,
                                          const CameraPose& pose) const;

  VirtualRoomSettings settings_;
  Film film_;
  std::unique_ptr<const RoomScene> scene_;
  RoomExtent extent_;
};

}  // namespace raywalk::simulator
