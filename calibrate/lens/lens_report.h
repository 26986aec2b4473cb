// The fit of the lenses as a page and as JSON.
#pragma once

#include <string>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// A page that stands alone: figures, start against fitted values with standard deviations, a
// picture of the residuals over both image circles and their size over the angle from the axis.
std::string lens_page(const LensFit& fit);

// {"format": "raywalk-lens", "format_version": 1, "method", "trustworthy", "warnings",
// "residual_px",
//  "pictures", "points", "overlap_points", "observations", "dropped_observations", "dropped_still",
//  "back_pose_fitted", "picture": {"width_px", "height_px", "two_files"},
//  "front": {"centre_u_px": {"start", "fitted", "sigma"}, ... "k4", "largest_angle_deg",
//            "imaging_sigma_px": {"middle", "rim"}},
//  "back": the same with "yaw_deg", "pitch_deg", "roll_deg",
//  "baseline_mm": {"x", "y", "z"}: of the back lens against the front, each as above,
//  "residuals_over_angle": [{"lens", "off_axis_deg", "count", "rms_px", "radial_px"}]}
std::string lens_json(const LensFit& fit);

}  // namespace raywalk::calibrate
