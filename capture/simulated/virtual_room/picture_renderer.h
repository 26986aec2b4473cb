// Pictures of a room through a camera: several rays per pixel, more where they differ.
#pragma once

#include <opencv2/core/mat.hpp>

#include "capture/simulated/virtual_room/camera_pose.h"
#include "capture/simulated/virtual_room/pixel_rays.h"
#include "capture/simulated/virtual_room/room_scene.h"

namespace raywalk::capture {

// How many rays a pixel is the mean of.
enum class Sampling {
  kDraft,  // 1: quick, with jagged edges
  kFine    // 4, and 16 where those differ by more than a few levels
};

// The picture (BGR, CV_8UC3) from the pose; black where the camera has no ray. `unit_m` is metres
// in a room unit. Where in a pixel the rays pass is a hash of the pixel, so a picture is the same
// whatever the number of threads. Throws Interrupted.
cv::Mat render_picture(const RoomScene& scene, const PixelRays& camera, const CameraPose& pose,
                       double unit_m, Sampling sampling);

}  // namespace raywalk::capture
