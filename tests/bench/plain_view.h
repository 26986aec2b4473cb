// The yardstick of raywalk-bench: a plain program for views, which mixes the two nearest stations
// at a constant distance. It reads the same mapped panoramas in the same scattered way as a view,
// so that a machine on which that is slow slows both.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/sphere.h"
#include "core/room/room.h"

namespace raywalk::bench {

// A panorama of the size of the captured ones, 8-bit RGB, [theta][phi], at a viewpoint in the
// room's first cell. `to` is reused where it has the size.
void render_plainly(const Room& room, PlanPoint viewpoint, cv::Mat3b& to);

}  // namespace raywalk::bench
