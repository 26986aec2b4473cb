// What makes two lenses of one camera differ in brightness, and how it is undone.
#pragma once

#include <array>

namespace raywalk::calibrate {

// Of the light that a lens would pass along its axis it passes, at the angle t from it,
//   exp(falloff_2 t^2 + falloff_4 t^4),
// the same for both lenses; the back one passes `back_gain` (blue, green, red) times as much as the
// front one. The default changes nothing. An even polynomial as t -> -t is the same place's
// mirror image; in the exponent, as then it never falls to 0 and measured ratios of light are
// linear in its coefficients.
struct LensBalance {
  std::array<double, 3> back_gain{1.0, 1.0, 1.0};
  double falloff_2 = 0.0;
  double falloff_4 = 0.0;

  // Share of the light on the axis that arrives at an angle, radians.
  double share_at(double angle_rad) const;
};

// By what levels, shifted as core/panorama/srgb.h has it, have to be multiplied to undo a factor of
// light: the front lens's exposure on its axis stays as it is.
double root_of_light(double factor);

}  // namespace raywalk::calibrate
