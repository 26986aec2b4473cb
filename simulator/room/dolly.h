// The dolly under a simulated camera, visible in all of its pictures.
#pragma once

#include "simulator/room/facets.h"

namespace raywalk::capture {

struct DollySettings {
  bool visible = false;
  // Angle from the nadir at which the middle of the platform's edges is seen, 10 to 45; corners and
  // wheels extend further. Below 10 the pole would extend beyond the platform.
  double reach_deg = 20.0;
};

// A plate under the camera, a pole, a square platform on four wheels on the floor, and a short
// piece of rail, in the camera's frame (RenderOptions::carried). The floor is `floor_m` below the
// camera; all sizes are proportional to it. Throws Error unless it is positive.
Facets make_dolly(const DollySettings& dolly, double floor_m);

}  // namespace raywalk::capture
