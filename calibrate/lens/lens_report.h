// The fit of the lenses as JSON and as an HTML page.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "core/report/html_page.h"

namespace raywalk::calibrate {

// {"format": "raywalk-lens", "format_version": 1, "method", "trustworthy", "warnings",
//  "residual_px", "worst_imaging_sigma_px", "pictures", "points", "overlap_points",
//  "observations", "dropped_observations", "dropped_still", "back_pose_fitted",
//  "picture": {"width_px", "height_px", "two_files"},
//  "front": {"centre_u_px": {"start", "fitted", "sigma" (null: not fitted)}, ... "k4",
//            "largest_angle_deg", "imaging_sigma_px": {"middle", "rim"}},
//  "back": the same with "yaw_deg", "pitch_deg", "roll_deg",
//  "baseline_mm": {"x", "y", "z"}: from the front lens to the back lens, each as above,
//  "residuals_over_angle": [{"lens", "off_axis_deg", "count", "rms_px", "radial_px"}]}
nlohmann::ordered_json lens_document(const LensFit& fit);

// The residuals over the image circle of each lens.
std::vector<HtmlFigure> residual_figures(const LensFit& fit);

// A self-contained page: figures, starting and fitted values with standard deviations, the
// residuals over both image circles and their size over the angle from the axis. `document`: of
// lens.json.
std::string lens_page(const nlohmann::ordered_json& document, std::vector<HtmlFigure> residuals);

}  // namespace raywalk::calibrate
