// The residuals of a lens as arrows over its image circle.
#pragma once

#include <string>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// A complete <svg> element that follows the reader's light or dark mode. Arrows are enlarged to be
// visible, with a scale bar. Of very many residuals an evenly spaced subset is drawn.
std::string residual_picture(const LensFit& fit, bool back);

}  // namespace raywalk::calibrate
