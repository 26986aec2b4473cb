// The residuals of a lens as arrows over its image circle.
#pragma once

#include <string>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// A complete <svg> element that follows the reader's light or dark mode. Arrows are enlarged so
// that typical ones can be seen; a scale tells by how much. Of very many residuals an even share is
// drawn.
std::string residual_picture(const LensFit& fit, bool back);

}  // namespace raywalk::calibrate
