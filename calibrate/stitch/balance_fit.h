// Fits the balance of two lenses to the brightness of the same surfaces at different places of
// their pictures.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calibrate/stitch/lens_balance.h"

namespace raywalk::calibrate {

// The place of an observation in a lens's picture.
struct LensPlace {
  bool back = false;
  double angle_rad = 0.0;  // from the lens's axis
};

// The same surface seen twice.
struct LightRatio {
  LensPlace first{};
  LensPlace second{};
  std::array<double, 3> log_light{};  // ln(light at second / light at first): blue, green, red
  // Number of the pair of frames, from 0, as each pair has its own ratio of exposures; nullopt:
  // both observations are from one frame.
  std::optional<int> frames{};
};

struct BalanceFit {
  LensBalance balance{};
  // Standard deviations of the logarithms of the back lens's gain and of the share of light at 45
  // and 90 degrees. From the scatter of the ratios, assumed independent.
  double gain_sigma = 0.0;
  double share_45_sigma = 0.0;
  double share_90_sigma = 0.0;
  double scatter = 0.0;  // of the logarithm of a ratio about the fit, robust
  int ratios = 0;
};

// Least squares of the logarithms, in which the model is linear:
//   ln ratio = ln gain (back - front) + falloff_2 (t2^2 - t1^2) + falloff_4 (t2^4 - t1^4) +
//   exposure,
// with Cauchy weights against wrong correspondences. Weak priors towards no falloff fix what the
// ratios do not determine: those from the overlap of two lenses alone determine the slope of the
// falloff at the rim, not its values further in. Without ratios the balance is the identity and the
// sigmas are those of the priors.
BalanceFit fit_balance(const std::vector<LightRatio>& ratios);

}  // namespace raywalk::calibrate
