// What a plan asks for and what it will give: the answer of `raywalk-capture plan`.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/plan/capture_plan.h"
#include "capture/plan/capture_time.h"

namespace raywalk::capture {

// What the spacing of the stations can resolve where views are made without distances
// (core/geometry/spacing.h). Pixels are those of a panorama as wide as a frame: also for
// dual-fisheye frames, whose two circles of a bit more than 180 degrees lie side by side.
struct SpacingReport {
  int panorama_width_px = 0;
  double tolerance_px = 0.0;
  double nearest_resolved_m = 0.0;  // surfaces from here on stay within the tolerance
  // By the scene's own distances; none where scene.nearest_m is unknown.
  std::optional<double> ghost_px{};   // how far apart copies of the nearest surface lie
  std::optional<double> needed_mm{};  // spacing that would keep them within the tolerance; none
                                      // also where any would

  bool too_coarse() const { return ghost_px && *ghost_px > tolerance_px; }
};

struct PlanReport {
  int lines = 0;  // of the grid
  std::size_t stations = 0;
  int validation_lines = 0;
  std::size_t validation_stations = 0;
  std::size_t exposures = 1;  // per station
  bool film = false;          // run.mode video

  double spacing_mm = 0.0;
  double first_mm = 0.0;  // on the rail, of all lines
  double last_mm = 0.0;
  double low_limit_mm = 0.0;
  double high_limit_mm = 0.0;

  double k_deg = 0.0;
  double blend_deg = 0.0;
  double overhang_mm = 0.0;
  double overhang_needed_mm = 0.0;
  double angle_reached_deg = 0.0;  // as angle_reached_deg() of capture_plan.h

  double picture_s = 0.0;  // per station
  CaptureTime time{};
  std::optional<double> picture_mb{};      // of one exposure; none where it cannot be estimated
  std::optional<SpacingReport> spacing{};  // none where camera.width_px is unknown

  std::size_t pictures() const { return (stations + validation_stations) * exposures; }
};

PlanReport report_of(const CapturePlan& plan, const CaptureConfig& config);

// Lines for people, warnings last.
std::string plan_report_text(const PlanReport& report);
// The members above, nested, with their units; null for what is none.
nlohmann::json plan_report_json(const PlanReport& report);

}  // namespace raywalk::capture
