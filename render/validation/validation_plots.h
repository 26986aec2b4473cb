// The plots of a validation's page, as SVG.
#pragma once

#include <optional>
#include <string>

#include "render/validation/validate.h"

namespace raywalk::render {

// A metric of Fig. 13.
struct QuarterMetric {
  const char* name;              // "PSNR"
  const char* axis;              // the name with its unit
  double QuarterScore::*member;  // larger is better
};

inline constexpr QuarterMetric kQuarterPsnr{"PSNR", "PSNR / dB", &QuarterScore::psnr_db};
inline constexpr QuarterMetric kQuarterSsim{"SSIM", "SSIM", &QuarterScore::ssim};
inline constexpr QuarterMetric kQuarterFsim{"FSIM", "FSIM", &QuarterScore::fsim};

// Index of the mode that makes initial views; none if that was not asked for.
std::optional<std::size_t> initial_mode(const Validation& validation);

// A metric of every quarter over its distance from the line, one series for each mode.
std::string metric_plot(const Validation& validation, const QuarterMetric& metric);

// What each mode gains over the initial view (which is drawn as the zero), over the distance from
// the line. Needs initial_mode().
std::string gain_plot(const Validation& validation, const QuarterMetric& metric);

// E_connect over k, one series for each generation.
std::string connection_error_plot(const Validation& validation);

// The same at a scale at which the corrected generations can be told apart: they lie far below the
// initial views. None where they or the initial views were not measured.
std::optional<std::string> corrected_connection_error_plot(const Validation& validation);

}  // namespace raywalk::render
