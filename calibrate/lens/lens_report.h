// The fit of the lenses as JSON, and its residuals as arrows over the image circles.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// {"format": "raywalk-lens", "format_version": 1, "trustworthy", "warnings",
//  "residual_px", "worst_imaging_sigma_px", "pictures", "points", "overlap_points",
//  "observations", "dropped_observations", "dropped_still",
//  "picture": {"width_px", "height_px", "two_files"},
//  "front": {"centre_u_px": {"start", "fitted", "sigma" (null: not fitted)}, ... "k4",
//            "largest_angle_deg", "imaging_sigma_px": {"middle", "rim"}},
//  "back": the same with "yaw_deg", "pitch_deg", "roll_deg",
//  "baseline_mm": {"x", "y", "z"}: from the front lens to the back lens, each as above,
//  "residuals_over_angle": [{"lens", "off_axis_deg", "count", "rms_px", "radial_px"}]};
//  calibrate_lens adds "figures".
nlohmann::ordered_json lens_document(const LensFit& fit);

// Writes an image of each lens into OUT/figures; returns the list for lens.json (figures.h). Arrows
// are enlarged to be visible. Of very many residuals an evenly spaced subset is drawn.
nlohmann::ordered_json residual_figures(const LensFit& fit, const std::filesystem::path& out);

}  // namespace raywalk::calibrate
