// What the plan's spacing gave in rooms that were measured.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/plan/measured_spacing.h"

namespace raywalk::capture {

struct QualityReport {
  double spacing_share = 0.0;                 // spacing over scene.nearest_m
  MeasuredShares measured{};                  // shares at which rooms were measured
  std::optional<ExpectedQuality> expected{};  // none outside of these
};

// None if `nearest_m` is 0 (unknown).
std::optional<QualityReport> quality_report(double spacing_mm, double nearest_m,
                                            const std::vector<MeasuredRoom>& rooms);

// Lines of text.
std::string quality_text(const std::optional<QualityReport>& report);
// Null if there is no report.
nlohmann::json quality_json(const std::optional<QualityReport>& report);

}  // namespace raywalk::capture
