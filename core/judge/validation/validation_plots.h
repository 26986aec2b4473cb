// The plots of the validation report, as SVG.
#pragma once

#include <optional>
#include <string>

#include "core/judge/validation/validate.h"

namespace raywalk {

// A metric of Fig. 13.
struct QuarterMetric {
  const char* name;              // "PSNR"
  const char* axis;              // the name with its unit
  double QuarterScore::*member;  // larger is better
};

inline constexpr QuarterMetric kQuarterPsnr{"PSNR", "PSNR / dB", &QuarterScore::psnr_db};
inline constexpr QuarterMetric kQuarterSsim{"SSIM", "SSIM", &QuarterScore::ssim};
inline constexpr QuarterMetric kQuarterFsim{"FSIM", "FSIM", &QuarterScore::fsim};

// Index of the mode with initial views; none if there is none.
std::optional<std::size_t> initial_mode(const Validation& validation);

// A metric of every quarter over its distance from the line, one series for each mode.
std::string metric_plot(const Validation& validation, const QuarterMetric& metric);

// The gain of each mode over the initial view, which is the zero line, over the distance from the
// line. initial_mode() must have a value.
std::string gain_plot(const Validation& validation, const QuarterMetric& metric);

// E_connect over k, one series for each generation.
std::string connection_error_plot(const Validation& validation);

// The same at a scale that resolves the corrected generations, which lie far below the initial
// views. None where they or the initial views were not measured.
std::optional<std::string> corrected_connection_error_plot(const Validation& validation);

}  // namespace raywalk
