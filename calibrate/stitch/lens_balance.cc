#include "calibrate/stitch/lens_balance.h"

#include <cmath>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {

double LensBalance::share_at(double angle_rad) const {
  const double square = angle_rad * angle_rad;
  return std::exp(square * (falloff_2 + square * falloff_4));
}

double root_of_light(double factor) { return std::pow(factor, -1.0 / kSrgbExponent); }

}  // namespace raywalk::calibrate
