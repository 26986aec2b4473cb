// Renders pictures of a room with adaptive supersampling.
#pragma once

#include <opencv2/core/mat.hpp>

#include "simulator/room/camera_pose.h"
#include "simulator/room/pixel_rays.h"
#include "simulator/room/room_scene.h"
#include "simulator/room/tone.h"

namespace raywalk::capture {

// Rays per pixel.
enum class Sampling {
  kDraft,  // 1: fast, with aliasing
  kFine    // 4, or 16 if those differ by more than a few levels
};

// How light becomes levels.
struct Film {
  float exposure = 1.0F;  // multiplies all light
  Highlights highlights = Highlights::kSoft;
};

// Renders the picture (BGR, CV_8UC3) from the pose; black where the camera has no ray. `unit_m` is
// the length of a room unit in metres. Ray positions within a pixel are a hash of the pixel, so the
// result does not depend on the number of threads. `people`, if any, are in the room. Throws
// Interrupted.
cv::Mat render_picture(const RoomScene& scene, const PixelRays& camera, const CameraPose& pose,
                       double unit_m, Sampling sampling, const Film& film = {},
                       const PeopleScene* people = nullptr);

}  // namespace raywalk::capture
