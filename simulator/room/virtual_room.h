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
#include <optional>

#include "simulator/room/cameras.h"
#include "simulator/room/embree_scene.h"
#include "simulator/room/light_map.h"
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

class Bodies;

// The 8-bit level, not rounded, of linear light relative to white, encoded with the sRGB transfer
// function (IEC 61966-2-1). Light below 0 counts as 0; light above 0.8 is compressed smoothly
// towards white, or clipped at white.
float level_from_light(float light, bool clip = false);

// Thread-safe.
class VirtualRoom {
 public:
  // Reads settings.scene.file and lights the scene, which takes about a second. Throws UsageError
  // if there is no such scene (read_scene), Error if the ray tracer fails, Interrupted.
  explicit VirtualRoom(const VirtualRoomSettings& settings);
  VirtualRoom(const VirtualRoomSettings& settings, Scene scene);
  // The light map refers to the scene.
  VirtualRoom(const VirtualRoom&) = delete;
  VirtualRoom& operator=(const VirtualRoom&) = delete;

  const VirtualRoomSettings& settings() const { return settings_; }
  RoomExtent extent() const { return extent_; }
  bool has_moving_objects() const { return !scene_.moving.empty(); }
  // Whether a camera may be there: in the room, not inside a solid, and with nothing nearer at its
  // height than `around_m`.
  bool is_free(const Eigen::Vector3d& position_m, double around_m) const;

  // The functions below throw Error naming the scene and the position if the camera is outside the
  // room or inside a solid, and Interrupted.

  // What the camera sees, BGR in CV_8UC3, noise-free; black where the camera has no ray. A pixel
  // has 4 rays, or 16 if those differ by more than a few levels; their positions in it are a hash
  // of it.
  cv::Mat render(const PixelRays& camera, const CameraPose& pose,
                 const RenderOptions& options = {}) const;

  // CV_8UC1: 255 where the ray through a pixel's centre of the panorama meets a moving object.
  cv::Mat moving_mask(int station, const CameraPose& pose, PanoramaSize size) const;

  // Metres along the ray through each pixel's centre of the panorama to the first surface of the
  // room without moving objects, CV_32FC1; +inf for the sky. A pane of glass is looked through: the
  // distance is that to what is behind it. The distance to a mirror is that to its surface.
  cv::Mat distance_map(const CameraPose& pose, PanoramaSize size) const;

  // The two functions below are for rays in the scene's frame.

  // The light along the ray: linear, relative to white, filtered for a pixel of the angle
  // `pixel_rad`. `bodies`, if any, are in the room.
  Color look(const Ray& ray, double pixel_rad, const Bodies* bodies = nullptr) const;

  // The distance along the ray to the first surface that is not a pane of glass; +inf for the sky.
  double measure(const Ray& ray) const;

 private:
  CameraPose in_scene(const CameraPose& pose) const;
  void require_free(const Eigen::Vector3d& position_m) const;
  bool is_inside_solid(const Eigen::Vector3d& in_scene_m) const;
  std::unique_ptr<const Bodies> bodies_of(const RenderOptions& options,
                                          const CameraPose& pose) const;
  const Facet& facet(const Hit& hit) const;
  const Surface& surface_of(const Facet& facet) const;
  // In the three functions below, `travelled` is the length of the light's path before the ray.
  Color light_of(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color reflection(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color diffuse_light(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  // `seen` at `distance`, as it looks through the panes in front of it.
  Color through_glass(const Ray& ray, double distance, const Color& seen, double pixel_rad) const;

  VirtualRoomSettings settings_;
  Scene scene_;
  EmbreeScene solids_;                // without panes of glass
  std::optional<EmbreeScene> glass_;  // none if there are no panes
  LightMap light_map_;
  RoomExtent extent_;
};

}  // namespace raywalk::simulator
