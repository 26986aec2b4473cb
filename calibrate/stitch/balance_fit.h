// The balance of two lenses, fitted to how bright the same things look in different places of their
// pictures.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calibrate/stitch/lens_balance.h"

namespace raywalk::calibrate {

// Where in a lens's picture something was seen.
struct LensPlace {
  bool back = false;
  double angle_rad = 0.0;  // from the lens's axis
};

// The same thing seen twice.
struct LightRatio {
  LensPlace first{};
  LensPlace second{};
  std::array<double, 3> log_light{};  // ln(light at second / light at first): blue, green, red
  // Which pair of frames it comes from, from 0, as two frames may be exposed differently; none:
  // both from one frame.
  std::optional<int> frames{};
};

struct BalanceFit {
  LensBalance balance{};
  // Standard deviations of the logarithm: of the back lens's gain, and of the share of light at 45
  // and 90 degrees. From the scatter of the ratios, taken to be independent.
  double gain_sigma = 0.0;
  double share_45_sigma = 0.0;
  double share_90_sigma = 0.0;
  double scatter = 0.0;  // of the logarithm of a ratio about the fit, robust
  int ratios = 0;
};

// Least squares of the logarithms, in which the model is linear:
//   ln ratio = ln gain (back - front) + falloff_2 (t2^2 - t1^2) + falloff_4 (t2^4 - t1^4) +
//   exposure,
// with Cauchy's weights against what is not the same thing after all. Weak priors (a lens passes
// much of its light at the rim) keep what the ratios do not determine near "no falloff": ratios
// from the overlap of two lenses alone tell the falloff's slope at the rim, not its course within.
// Without ratios: a balance that changes nothing, sigmas those of the priors.
BalanceFit fit_balance(const std::vector<LightRatio>& ratios);

}  // namespace raywalk::calibrate
