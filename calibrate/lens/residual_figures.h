// The residuals of the lenses as arrows over their image circles.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// Writes an image of each lens into OUT/figures; returns the list for lens.json (figures.h). Arrows
// are enlarged to be visible. Of very many residuals an evenly spaced subset is drawn.
nlohmann::ordered_json residual_figures(const LensFit& fit, const std::filesystem::path& out);

}  // namespace raywalk::calibrate
