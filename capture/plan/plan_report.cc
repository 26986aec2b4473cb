#include "capture/plan/plan_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "capture/base/units.h"
#include "core/base/number_text.h"
#include "core/geometry/spacing.h"

namespace raywalk::capture {
namespace {

// JPEG files of 360-degree cameras: 4 bits per pixel (8 to 9 MB at 6720 x 3360).
constexpr double kJpegBytesPerPixel = 0.5;
constexpr double kMegabytesPerGigabyte = 1000.0;
constexpr double kSecondsPerMinute = 60.0;
constexpr double kSecondsPerHour = 3600.0;

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
  const InverseRange range{scene.farthest_m > 0.0 ? 1.0 / scene.farthest_m : 0.0,
                           1.0 / scene.nearest_m};
  const double ghost_px =
      largest_ghost_without_depth(range, spacing_m) / angle_of_pixels(1.0, width_px);
  const double needed_m = spacing_needed_without_depth(range, tolerance_rad);
  spacing["ghost_px"] = ghost_px;  // between the copies of the nearest surface
  if (std::isfinite(needed_m)) spacing["needed_mm"] = needed_m * kMillimetresPerMetre;
  spacing["too_coarse"] = ghost_px > scene.tolerance_px;
  return spacing;
}

std::int64_t rounded_up(double parts) { return static_cast<std::int64_t>(std::ceil(parts)); }

// 0: unknown. A charge ends at the first of its two limits.
std::int64_t battery_charges(const CaptureConfig& config, double total_s, double pictures) {
  const CameraConfig& camera = config.camera;
  std::int64_t charges = 0;
  if (camera.battery_pictures > 0 && config.run.mode == CaptureMode::kStations) {
    charges = rounded_up(pictures / camera.battery_pictures);
  }
  if (camera.battery_min > 0.0) {
    charges = std::max(charges, rounded_up(total_s / (camera.battery_min * kSecondsPerMinute)));
  }
  return charges;
}

// 0: unknown, or a day is too short to begin it. Every day but the first begins with homing and
// with placing the rail where it was the evening before: the estimated time has both once already.
std::int64_t days_needed(const CaptureConfig& config, double total_s) {
  const double day_s = config.run.work_h_per_day * kSecondsPerHour;
  const double begin_s = homing_s(config) + config.run.placing_s;
  if (day_s <= 0.0) return 0;
  if (total_s <= day_s) return 1;
  if (day_s <= begin_s) return 0;
  return 1 + rounded_up((total_s - day_s) / (day_s - begin_s));
}

// 0: unknown, or a card is smaller than a picture. The size of videos is not estimated.
std::int64_t pictures_of_card(const CaptureConfig& config,
                              const std::optional<double>& picture_mb) {
  const bool has_card = config.camera.kind != CameraKind::kV4l2;
  if (!has_card || config.run.mode == CaptureMode::kVideo || !picture_mb) return 0;
  return static_cast<std::int64_t>(config.camera.card_gb * kMegabytesPerGigabyte / *picture_mb);
}

template <typename Number>
PlanJson known_or_null(Number value) {
  return value > 0 ? PlanJson(value) : PlanJson();
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

PlanJson field_work(const CapturePlan& plan, const CaptureConfig& config, const CaptureTime& time,
                    std::size_t pictures, const std::optional<double>& picture_mb) {
  const auto count = static_cast<double>(pictures);
  const std::int64_t charges = battery_charges(config, time.total_s(), count);
  const double changes = static_cast<double>(std::max<std::int64_t>(charges - 1, 0));
  const double changes_s = changes * config.run.battery_change_s;
  const std::int64_t days = days_needed(config, time.total_s() + changes_s);
  const std::int64_t per_card = pictures_of_card(config, picture_mb);
  const std::int64_t cards = per_card > 0 ? rounded_up(count / static_cast<double>(per_card)) : 0;
  return {{"placements", placements_of(plan).size()},
          {"hours_per_day", known_or_null(config.run.work_h_per_day)},
          {"days", known_or_null(days)},
          {"uses_cards", config.camera.kind != CameraKind::kV4l2},
          {"card_gb", known_or_null(config.camera.card_gb)},
          {"pictures_per_card", known_or_null(per_card)},
          {"cards", known_or_null(cards)},
          {"battery_charges", known_or_null(charges)},
          {"battery_charges_per_day", known_or_null(days > 0 ? (charges + days - 1) / days : 0)},
          {"battery_changes_s", changes_s}};
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
  report["video"] = config.run.mode == CaptureMode::kVideo;
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
