// The fit of the lenses as an HTML page and as JSON.
#pragma once

#include <string>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// A self-contained page: figures, starting and fitted values with standard deviations, a plot of
// the residuals over both image circles and of their size over the angle from the axis.
std::string lens_page(const LensFit& fit);

// {"format": "raywalk-lens", "format_version": 1, "method", "trustworthy", "warnings",
// "residual_px",
//  "pictures", "points", "overlap_points", "observations", "dropped_observations", "dropped_still",
//  "back_pose_fitted", "picture": {"width_px", "height_px", "two_files"},
//  "front": {"centre_u_px": {"start", "fitted", "sigma"}, ... "k4", "largest_angle_deg",
//            "imaging_sigma_px": {"middle", "rim"}},
//  "back": the same with "yaw_deg", "pitch_deg", "roll_deg",
//  "baseline_mm": {"x", "y", "z"}: from the front lens to the back lens, each as above,
//  "residuals_over_angle": [{"lens", "off_axis_deg", "count", "rms_px", "radial_px"}]}
std::string lens_json(const LensFit& fit);

}  // namespace raywalk::calibrate
