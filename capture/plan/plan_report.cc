#include "capture/plan/plan_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/base/units.h"
#include "core/base/number_text.h"
#include "core/geometry/spacing.h"

namespace raywalk::capture {
namespace {

// JPEG files of 360-degree cameras: 4 bits per pixel (8 to 9 MB at 6720 x 3360).
constexpr double kJpegBytesPerPixel = 0.5;
constexpr double kBytesPerMegabyte = 1e6;

double along_m(const CaptureLine& line, const CaptureStation& station) {
  return line.axis == LineAxis::kX ? station.position_m.x_m : station.position_m.z_m;
}

PlanJson lines_json(const CapturePlan& plan) {
  PlanJson lines = PlanJson::array();
  for (const CaptureLine& line : plan.lines) {
    std::vector<double> placements_from_m;
    for (const CaptureLine& placement : placements_of(line)) {
      placements_from_m.push_back(along_m(line, placement.stations.front()));
    }
    lines.push_back({{"id", line.id},
                     {"axis", name_of(line.axis)},
                     {"across_m", line.across_m},
                     {"from_m", along_m(line, line.stations.front())},
                     {"to_m", along_m(line, line.stations.back())},
                     {"overhang_m", line.validation ? 0.0 : plan.overhang_m},
                     {"stations", line.stations.size()},
                     {"placements_from_m", placements_from_m},
                     {"validation", line.validation}});
  }
  return lines;
}

// The lines of the grid along one axis are equal but for their place.
PlanJson groups_json(const PlanJson& lines) {
  PlanJson groups = PlanJson::array();
  for (const PlanJson& line : lines) {
    if (line["validation"]) continue;
    if (groups.empty() || groups.back()["axis"] != line["axis"]) {
      groups.push_back({{"axis", line["axis"]},
                        {"lines", 0},
                        {"first", line["id"]},
                        {"last", ""},
                        {"stations_per_line", line["stations"]},
                        {"length_m", line["to_m"].get<double>() - line["from_m"].get<double>()},
                        {"placements_per_line", line["placements_from_m"].size()}});
    }
    groups.back()["lines"] = groups.back()["lines"].get<int>() + 1;
    groups.back()["last"] = line["id"];
  }
  return groups;
}

// Of the lines of the grid, or of those for validation.
PlanJson counts_json(const CapturePlan& plan, bool validation) {
  std::size_t lines = 0, stations = 0;
  for (const CaptureLine& line : plan.lines) {
    if (line.validation != validation) continue;
    lines += 1;
    stations += line.stations.size();
  }
  return {{"lines", lines}, {"stations", stations}};
}

PlanJson rail_json(const CapturePlan& plan, const SliderConfig& slider) {
  const double first_mm = plan.lines.front().stations.front().rail_mm;
  double last_mm = first_mm;
  for (const CaptureLine& line : plan.lines) {
    for (const CaptureStation& station : line.stations) {
      last_mm = std::max(last_mm, station.rail_mm);
    }
  }
  return {{"first_mm", first_mm},
          {"last_mm", last_mm},
          {"low_limit_mm", slider.low_limit_mm},
          {"high_limit_mm", slider.high_limit_mm}};
}

PlanJson time_json(const CaptureTime& time, const CaptureConfig& config) {
  return {{"motion_s", time.motion_s},     {"settling_s", time.settling_s},
          {"pictures_s", time.pictures_s}, {"placing_s", time.placing_s},
          {"total_s", time.total_s()},     {"one_station_s", picture_s(config)}};
}

// What the spacing resolves in views rendered without distances (core/geometry/spacing.h). Pixels
// are those of a panorama as wide as a frame, also for dual-fisheye frames, whose two circles of
// about 180 degrees lie side by side.
PlanJson spacing_json(const CaptureScene& scene, int width_px, double spacing_mm) {
  if (width_px == 0) return {};
  const double spacing_m = spacing_mm / kMillimetresPerMetre;
  const double tolerance_rad = angle_of_pixels(scene.tolerance_px, width_px);
  PlanJson spacing{{"panorama_width_px", width_px},
                   {"tolerance_px", scene.tolerance_px},
                   {"nearest_resolved_m", nearest_distance_resolved(spacing_m, tolerance_rad)},
                   {"ghost_px", nullptr},
                   {"needed_mm", nullptr},
                   {"too_coarse", false}};
  if (scene.nearest_m == 0.0) return spacing;
  const OmegaRange range{scene.farthest_m > 0.0 ? 1.0 / scene.farthest_m : 0.0,
                         1.0 / scene.nearest_m};
  const double ghost_px =
      largest_ghost_without_depth(range, spacing_m) / angle_of_pixels(1.0, width_px);
  const double needed_m = spacing_needed_without_depth(range, tolerance_rad);
  spacing["ghost_px"] = ghost_px;  // between the copies of the nearest surface
  if (std::isfinite(needed_m)) spacing["needed_mm"] = needed_m * kMillimetresPerMetre;
  spacing["too_coarse"] = ghost_px > scene.tolerance_px;
  return spacing;
}

PlanJson warnings_json(const PlanJson& report) {
  PlanJson warnings = PlanJson::array();
  const double k_deg = report["overhang"]["k_deg"];
  const double reached_deg = report["overhang"]["angle_reached_deg"];
  if (reached_deg > k_deg + 0.01) {
    warnings.push_back(fmt::format(
        "the overhang is too short for k = {} degrees; at worst, views near a side of the grid "
        "connect at {:.1f}. Raise grid.overhang_mm or set it to -1",
        plain_number(k_deg, 2), reached_deg));
  }
  if (!report["spacing"].is_null() && report["spacing"]["too_coarse"]) {
    warnings.push_back(
        "the spacing is too coarse for the scene without distances. Reduce it, or render with "
        "distance maps");
  }
  return warnings;
}

}  // namespace

std::optional<double> picture_mb(const CaptureConfig& config) {
  if (config.run.picture_mb > 0.0) return config.run.picture_mb;
  const double pixels = static_cast<double>(config.camera.width_px) * config.camera.height_px;
  if (pixels == 0.0) return std::nullopt;
  return pixels * kJpegBytesPerPixel / kBytesPerMegabyte;
}

PlanJson plan_report(const CapturePlan& plan, const CaptureConfig& config) {
  const std::vector<CaptureStation>& stations = plan.lines.front().stations;
  const double spacing_mm = stations[1].rail_mm - stations[0].rail_mm;
  const std::size_t exposures = config.camera.exposure.bracket_ev.size();
  const std::size_t pictures = plan.stations() * exposures;
  const std::optional<double> size_mb = picture_mb(config);
  const CaptureTime time = estimate_time(plan, config);
  const PlanJson lines = lines_json(plan);
  PlanJson report;
  report["grid"] = counts_json(plan, false);
  report["grid"]["groups"] = groups_json(lines);
  report["validation"] = counts_json(plan, true);
  report["rail"] = rail_json(plan, config.slider);
  report["overhang"] = {{"planned_mm", plan.overhang_m * kMillimetresPerMetre},
                        {"needed_mm", overhang_needed_m(config.grid) * kMillimetresPerMetre},
                        {"k_deg", config.grid.k_deg},
                        {"blend_deg", config.grid.blend_deg},
                        {"angle_reached_deg", angle_reached_deg(config.grid, plan.overhang_m)}};
  report["film"] = config.run.mode == CaptureMode::kVideo;
  report["time"] = time_json(time, config);
  report["storage"] = {{"pictures", pictures},
                       {"exposures_per_station", exposures},
                       {"picture_mb", size_mb ? PlanJson(*size_mb) : PlanJson()}};
  report["work"] = field_work(plan, config, time, pictures, size_mb);
  report["spacing_mm"] = spacing_mm;
  report["spacing"] = spacing_json(config.scene, config.camera.width_px, spacing_mm);
  report["warnings"] = warnings_json(report);
  report["summary"] = plan_summary(report);
  report["lines"] = lines;
  return report;
}

}  // namespace raywalk::capture
