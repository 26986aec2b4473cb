// Renders pictures of a room with adaptive supersampling.
#pragma once

#include <opencv2/core/mat.hpp>

#include "simulator/room/cameras.h"
#include "simulator/room/room_scene.h"

namespace raywalk::simulator {

// How light becomes levels: light above 0.8 is compressed smoothly towards white, or clipped at
// white.
struct Film {
  float exposure = 1.0F;  // multiplies all light
  bool clip = false;
};

// The 8-bit level, not rounded, of linear light relative to white, encoded with the sRGB transfer
// function (IEC 61966-2-1). Light below 0 counts as 0.
float level_from_light(float light, bool clip = false);

// Renders the picture (BGR, CV_8UC3) from the pose in the scene's frame; black where the camera has
// no ray. A pixel has 4 rays, or 16 if those differ by more than a few levels. Ray positions within
// a pixel are a hash of the pixel, so the result does not depend on the number of threads.
// `bodies`, if any, are in the room. Throws Interrupted.
cv::Mat render_picture(const RoomScene& scene, const PixelRays& camera, const CameraPose& pose,
                       const Film& film = {}, const Bodies* bodies = nullptr);

}  // namespace raywalk::simulator
