// Calibrates the lenses of a dual-fisheye camera: radial models, image centres, and the pose of the
// back lens relative to the front lens.
//
// No target is needed: the rail gives the camera's displacement between the frames of a capture, so
// that features tracked along it and across the overlap of the two lenses determine every angle in
// the picture.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct LensOptions {
  std::filesystem::path start{};  // lens file with starting values
  int pairs = 24;                 // stations to use, at least 6
  double ignore_below_deg = 0.0;  // half angle of an ignored cone about the nadir, [0, 90)
  std::filesystem::path out{};    // directory
};

// Standard deviations.
struct LensUncertainty {
  double centre_u_px = 0.0;
  double centre_v_px = 0.0;
  double focal_px = 0.0;
  std::array<double, 4> k{};
  // Of the image position of a direction, root mean square over the directions around the axis. The
  // coefficients are strongly correlated, so only this measures the quality of the lens model.
  double middle_px = 0.0;  // half way to the rim, in angle
  double rim_px = 0.0;     // at the largest angle
};

struct CameraUncertainty {
  LensUncertainty front{};
  LensUncertainty back{};
  Eigen::Vector3d back_rotation_deg{0, 0, 0};  // about the back lens's x, y and z
  Eigen::Vector3d baseline_mm{0, 0, 0};        // from the front lens to the back lens

  double worst_px() const;  // the largest of the four imaging errors
};

// An observed image point and its residual.
struct LensResidual {
  bool back = false;      // which lens
  PixelPosition seen{};   // observed, pixels of the picture
  double right_px = 0.0;  // seen minus fitted
  double down_px = 0.0;
};

struct LensFit {
  DualFisheyeCamera start{};   // in the size of the pictures
  DualFisheyeCamera camera{};  // fitted
  double residual_px = 0.0;    // root mean square distance over the kept observations
  CameraUncertainty sigma{};
  int pictures = 0;        // stations used
  int points = 0;          // tracks
  int observations = 0;    // of these points, kept
  int overlap_points = 0;  // seen by both lenses
  int dropped_still = 0;   // tracks that move with the camera: dolly, pole, rim
  int dropped_observations = 0;
  std::vector<LensResidual> residuals{};
  std::vector<std::string> warnings{};  // why the result is not trustworthy

  bool trustworthy() const { return warnings.empty(); }
};

// Fits, and writes OUT/lens.yaml, OUT/lens.json and its figures. Throws UsageError for an invalid
// start file or options; Error for frames that are already panoramas, pictures of another aspect
// ratio than the start's, pictures whose motion contradicts the plan (mirrored, lenses swapped),
// and too few features; Interrupted.
LensFit calibrate_lens(const CaptureSet& set, const LensOptions& options);

// The fit alone, from a start in the size of the set's pictures, of frames that are checked
// (capture_fit.cc). Throws Error and Interrupted as calibrate_lens does.
LensFit fit_to_capture(const CaptureSet& set, const DualFisheyeCamera& start,
                       const LensOptions& options);

// lens.json:
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
