#include "capture/plan/plan_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/base/units.h"
#include "core/geometry/spacing.h"
#include "core/report/markup.h"

namespace raywalk::capture {
namespace {

// JPEG files of 360-degree cameras: 4 bits per pixel (8 to 9 MB at 6720 x 3360).
constexpr double kJpegBytesPerPixel = 0.5;
constexpr double kBytesPerMegabyte = 1e6;

std::optional<double> megabytes_of_picture(const CaptureConfig& config) {
  if (config.run.picture_mb > 0.0) return config.run.picture_mb;
  const double pixels = static_cast<double>(config.camera.width_px) * config.camera.height_px;
  if (pixels == 0.0) return std::nullopt;
  return pixels * kJpegBytesPerPixel / kBytesPerMegabyte;
}

std::optional<SpacingReport> spacing_report(const CaptureScene& scene, int width_px,
                                            double spacing_mm) {
  if (width_px == 0) return std::nullopt;
  const double spacing_m = spacing_mm / kMillimetresPerMetre;
  const double tolerance_rad = angle_of_pixels(scene.tolerance_px, width_px);
  SpacingReport report{width_px, scene.tolerance_px,
                       nearest_distance_resolved(spacing_m, tolerance_rad)};
  if (scene.nearest_m > 0.0) {
    const OmegaRange range{scene.farthest_m > 0.0 ? 1.0 / scene.farthest_m : 0.0,
                           1.0 / scene.nearest_m};
    report.ghost_px =
        largest_ghost_without_depth(range, spacing_m) / angle_of_pixels(1.0, width_px);
    const double needed_m = spacing_needed_without_depth(range, tolerance_rad);
    if (std::isfinite(needed_m)) report.needed_mm = needed_m * kMillimetresPerMetre;
  }
  return report;
}

void add_to_group(const CaptureLine& line, std::vector<LineGroup>* groups) {
  if (groups->empty() || groups->back().axis != line.axis) {
    const PlanPoint& from = line.stations.front().position_m;
    const PlanPoint& to = line.stations.back().position_m;
    groups->push_back({line.axis, 0, line.id, "", line.stations.size(),
                       std::hypot(to.x_m - from.x_m, to.z_m - from.z_m),
                       placements_of(line).size()});
  }
  groups->back().lines += 1;
  groups->back().last = line.id;
}

void add_lines(const CapturePlan& plan, PlanReport* report) {
  report->first_mm = plan.lines.front().stations.front().rail_mm;
  for (const CaptureLine& line : plan.lines) {
    (line.validation ? report->validation_lines : report->lines) += 1;
    (line.validation ? report->validation_stations : report->stations) += line.stations.size();
    for (const CaptureStation& station : line.stations) {
      report->last_mm = std::max(report->last_mm, station.rail_mm);
    }
    if (!line.validation) add_to_group(line, &report->groups);
  }
}

// "45 s", "12 min", "3 h 05 min".
std::string duration_text(double seconds) {
  const auto whole_s = static_cast<long>(std::round(seconds));
  if (whole_s < 60) return fmt::format("{} s", plain_number(seconds, seconds < 10.0 ? 1 : 0));
  const long minutes = (whole_s + 30) / 60;
  if (minutes < 60) return fmt::format("{} min", minutes);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string size_text(double megabytes) {
  if (megabytes >= 1000.0) return fmt::format("{} GB", plain_number(megabytes / 1000.0, 1));
  return fmt::format("{} MB", plain_number(megabytes, megabytes < 10.0 ? 1 : 0));
}

std::string lines_text(const PlanReport& report) {
  std::string text = fmt::format(
      "lines:     {}, {}, {} mm apart\n", counted(static_cast<std::size_t>(report.lines), "line"),
      counted(report.stations, "station"), plain_number(report.spacing_mm, 3));
  for (const LineGroup& group : report.groups) {
    text += fmt::format("           {} along {} ({} to {}): {}, {} m and {} of the rail each\n",
                        group.lines, name_of(group.axis), group.first, group.last,
                        counted(group.stations, "station"), plain_number(group.length_m, 3),
                        counted(group.placements, "placement"));
  }
  if (report.validation_lines > 0) {
    text += fmt::format("           {} for validation, {}\n",
                        counted(static_cast<std::size_t>(report.validation_lines), "line"),
                        counted(report.validation_stations, "station"));
  }
  return text;
}

std::string rail_text(const PlanReport& report) {
  return fmt::format("rail:      {} mm, from {} to {} mm within the limits {} to {} mm\n",
                     plain_number(report.last_mm - report.first_mm, 1),
                     plain_number(report.first_mm, 1), plain_number(report.last_mm, 1),
                     plain_number(report.low_limit_mm, 1), plain_number(report.high_limit_mm, 1));
}

std::string overhang_text(const PlanReport& report) {
  return fmt::format(
      "overhang:  {} mm beyond the outer corners; k = {} degrees with a blend of {} needs {} mm\n",
      plain_number(report.overhang_mm, 1), plain_number(report.k_deg, 2),
      plain_number(report.blend_deg, 2), plain_number(report.overhang_needed_mm, 1));
}

std::string time_text(const PlanReport& report) {
  const CaptureTime& time = report.time;
  const std::string pictures =
      report.film ? "filmed in motion"
                  : fmt::format("pictures {} ({} each)", duration_text(time.pictures_s),
                                duration_text(report.picture_s));
  return fmt::format("time:      about {}: moving {}, settling {}, {}, placing the rail {}\n",
                     duration_text(time.total_s()), duration_text(time.motion_s),
                     duration_text(time.settling_s), pictures, duration_text(time.placing_s));
}

std::string storage_text(const PlanReport& report) {
  if (!report.picture_mb) {
    return fmt::format(
        "storage:   {}; set run.picture_mb, or camera.width_px and height_px, to "
        "estimate their size\n",
        counted(report.pictures(), "picture"));
  }
  return fmt::format("storage:   about {}: {} of {}\n",
                     size_text(*report.picture_mb * static_cast<double>(report.pictures())),
                     counted(report.pictures(), "picture"), size_text(*report.picture_mb));
}

std::string spacing_text(const PlanReport& report) {
  if (!report.spacing) {
    return "spacing:   set camera.width_px and height_px to estimate the resolution\n";
  }
  const SpacingReport& spacing = *report.spacing;
  std::string text = fmt::format(
      "spacing:   without distances, resolves surfaces from {} m on within {} px of a panorama "
      "{} px wide\n",
      plain_number(spacing.nearest_resolved_m, 2), plain_number(spacing.tolerance_px, 2),
      spacing.panorama_width_px);
  if (!spacing.ghost_px) {
    text += "           set scene.nearest_m to estimate the spacing that the scene needs\n";
  } else {
    text += fmt::format(
        "           the nearest surface doubles by {} px; {}\n", plain_number(*spacing.ghost_px, 2),
        spacing.needed_mm
            ? fmt::format("{} mm would keep it within {} px", plain_number(*spacing.needed_mm, 2),
                          plain_number(spacing.tolerance_px, 2))
            : "any spacing would do");
  }
  return text;
}

std::string warnings_text(const PlanReport& report) {
  std::string text;
  if (report.angle_reached_deg > report.k_deg + 0.01) {
    text += fmt::format(
        "warning: the overhang is too short for k = {} degrees; at worst, views near a side of the "
        "grid connect at {:.1f}. Raise grid.overhang_mm or set it to -1\n",
        plain_number(report.k_deg, 2), report.angle_reached_deg);
  }
  if (report.spacing && report.spacing->too_coarse()) {
    text +=
        "warning: the spacing is too coarse for the scene without distances. Reduce it, or render "
        "with distance maps\n";
  }
  return text;
}

nlohmann::json number_or_null(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json groups_json(const std::vector<LineGroup>& groups) {
  nlohmann::json json = nlohmann::json::array();
  for (const LineGroup& group : groups) {
    json.push_back({{"axis", name_of(group.axis)},
                    {"lines", group.lines},
                    {"first", group.first},
                    {"last", group.last},
                    {"stations_per_line", group.stations},
                    {"length_m", group.length_m},
                    {"placements_per_line", group.placements}});
  }
  return json;
}

nlohmann::json spacing_json(const std::optional<SpacingReport>& spacing) {
  if (!spacing) return {};
  return {{"panorama_width_px", spacing->panorama_width_px},
          {"tolerance_px", spacing->tolerance_px},
          {"nearest_resolved_m", spacing->nearest_resolved_m},
          {"ghost_px", number_or_null(spacing->ghost_px)},
          {"needed_mm", number_or_null(spacing->needed_mm)},
          {"too_coarse", spacing->too_coarse()}};
}

}  // namespace

PlanReport report_of(const CapturePlan& plan, const CaptureConfig& config) {
  const std::vector<CaptureStation>& stations = plan.lines.front().stations;
  PlanReport report;
  add_lines(plan, &report);
  report.exposures = config.camera.exposure.bracket_ev.size();
  report.film = config.run.mode == CaptureMode::kVideo;
  report.spacing_mm = stations[1].rail_mm - stations[0].rail_mm;
  report.low_limit_mm = config.slider.low_limit_mm;
  report.high_limit_mm = config.slider.high_limit_mm;
  report.k_deg = config.grid.k_deg;
  report.blend_deg = config.grid.blend_deg;
  report.overhang_mm = plan.overhang_m * kMillimetresPerMetre;
  report.overhang_needed_mm = overhang_needed_m(config.grid) * kMillimetresPerMetre;
  report.angle_reached_deg = angle_reached_deg(config.grid, plan.overhang_m);
  report.picture_s = picture_s(config);
  report.time = estimate_time(plan, config);
  report.picture_mb = megabytes_of_picture(config);
  report.work = field_work(plan, config, report.time, report.pictures(), report.picture_mb);
  report.spacing = spacing_report(config.scene, config.camera.width_px, report.spacing_mm);
  report.quality = quality_report(report.spacing_mm, config.scene.nearest_m, measured_rooms());
  return report;
}

std::string plan_report_text(const PlanReport& report) {
  return lines_text(report) + rail_text(report) + overhang_text(report) + time_text(report) +
         storage_text(report) + field_work_text(report.work) + spacing_text(report) +
         quality_text(report.quality) + warnings_text(report);
}

nlohmann::json plan_report_json(const PlanReport& report) {
  return {{"grid",
           {{"lines", report.lines},
            {"stations", report.stations},
            {"groups", groups_json(report.groups)}}},
          {"validation",
           {{"lines", report.validation_lines}, {"stations", report.validation_stations}}},
          {"rail",
           {{"first_mm", report.first_mm},
            {"last_mm", report.last_mm},
            {"low_limit_mm", report.low_limit_mm},
            {"high_limit_mm", report.high_limit_mm}}},
          {"overhang",
           {{"planned_mm", report.overhang_mm},
            {"needed_mm", report.overhang_needed_mm},
            {"k_deg", report.k_deg},
            {"blend_deg", report.blend_deg},
            {"angle_reached_deg", report.angle_reached_deg}}},
          {"time",
           {{"motion_s", report.time.motion_s},
            {"settling_s", report.time.settling_s},
            {"pictures_s", report.time.pictures_s},
            {"placing_s", report.time.placing_s},
            {"total_s", report.time.total_s()}}},
          {"storage",
           {{"pictures", report.pictures()},
            {"exposures_per_station", report.exposures},
            {"picture_mb", number_or_null(report.picture_mb)}}},
          {"work", field_work_json(report.work)},
          {"spacing_mm", report.spacing_mm},
          {"spacing", spacing_json(report.spacing)},
          {"quality", quality_json(report.quality)},
          {"film", report.film}};
}

}  // namespace raywalk::capture
