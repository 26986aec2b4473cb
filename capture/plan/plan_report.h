// The report of `raywalk-capture plan`: stations, time, storage and resolution of a plan.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "capture/plan/capture_time.h"
#include "capture/plan/field_work.h"
#include "capture/plan/quality_report.h"

namespace raywalk::capture {

// The resolution that the spacing of the stations allows for views rendered without distances
// (core/geometry/spacing.h). Pixels are those of a panorama as wide as a frame, also for
// dual-fisheye frames, whose two circles of about 180 degrees lie side by side.
struct SpacingReport {
  int panorama_width_px = 0;
  double tolerance_px = 0.0;
  double nearest_resolved_m = 0.0;  // surfaces from this distance on stay within the tolerance
  // From the distances of the scene; none if scene.nearest_m is unknown.
  std::optional<double> ghost_px{};   // offset between the copies of the nearest surface
  std::optional<double> needed_mm{};  // spacing that keeps them within the tolerance; none
                                      // also if any spacing does

  bool too_coarse() const { return ghost_px && *ghost_px > tolerance_px; }
};

// The lines of the grid along one axis, which are equal but for their place.
struct LineGroup {
  LineAxis axis = LineAxis::kX;
  int lines = 0;
  std::string first{};         // their ids: "x0"
  std::string last{};          // "x6"
  std::size_t stations = 0;    // of each
  double length_m = 0.0;       // of each, first to last station
  std::size_t placements = 0;  // of the rail, for each
};

struct PlanReport {
  int lines = 0;                    // of the grid
  std::vector<LineGroup> groups{};  // of the grid's lines
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
  std::optional<double> picture_mb{};  // of one exposure; none if it cannot be estimated
  FieldWork work{};
  std::optional<SpacingReport> spacing{};  // none if camera.width_px is unknown
  std::optional<QualityReport> quality{};  // none if scene.nearest_m is unknown

  std::size_t pictures() const { return (stations + validation_stations) * exposures; }
};

PlanReport report_of(const CapturePlan& plan, const CaptureConfig& config);

// Lines of text, warnings last.
std::string plan_report_text(const PlanReport& report);
// The members above as nested JSON with units in the names; none is null.
nlohmann::json plan_report_json(const PlanReport& report);

}  // namespace raywalk::capture
