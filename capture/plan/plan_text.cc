// The report of a plan as text.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "capture/plan/plan_report.h"
#include "core/base/number_text.h"

namespace raywalk::capture {
namespace {

std::string number(const PlanJson& value, int decimals) {
  return plain_number(value.get<double>(), decimals);
}

std::string counted(const PlanJson& count, std::string_view noun) {
  return raywalk::counted(count.get<std::size_t>(), noun);
}

std::string duration(const PlanJson& value) { return duration_text(value.get<double>()); }

std::string size_text(double megabytes) {
  if (megabytes >= 1000.0) return fmt::format("{} GB", plain_number(megabytes / 1000.0, 1));
  return fmt::format("{} MB", plain_number(megabytes, megabytes < 10.0 ? 1 : 0));
}

std::string lines_text(const PlanJson& report) {
  const PlanJson& grid = report["grid"];
  std::string text =
      fmt::format("{}, {}, {} mm apart", counted(grid["lines"], "line"),
                  counted(grid["stations"], "station"), number(report["spacing_mm"], 3));
  for (const PlanJson& group : grid["groups"]) {
    text += fmt::format(
        "\n{} along {} ({} to {}): {}, {} m and {} of the rail each", group["lines"].get<int>(),
        group["axis"].get<std::string>(), group["first"].get<std::string>(),
        group["last"].get<std::string>(), counted(group["stations_per_line"], "station"),
        number(group["length_m"], 3), counted(group["placements_per_line"], "placement"));
  }
  const PlanJson& validation = report["validation"];
  if (validation["lines"] == 0) return text;
  return text + fmt::format("\n{} for validation, {}", counted(validation["lines"], "line"),
                            counted(validation["stations"], "station"));
}

std::string rail_text(const PlanJson& rail) {
  const double length_mm = rail["last_mm"].get<double>() - rail["first_mm"].get<double>();
  return fmt::format("{} mm, from {} to {} mm within the limits {} to {} mm",
                     plain_number(length_mm, 1), number(rail["first_mm"], 1),
                     number(rail["last_mm"], 1), number(rail["low_limit_mm"], 1),
                     number(rail["high_limit_mm"], 1));
}

std::string overhang_text(const PlanJson& overhang) {
  return fmt::format(
      "{} mm beyond the outer corners; k = {} degrees with a blend of {} needs "
      "{} mm",
      number(overhang["planned_mm"], 1), number(overhang["k_deg"], 2),
      number(overhang["blend_deg"], 2), number(overhang["needed_mm"], 1));
}

std::string time_text(const PlanJson& report) {
  const PlanJson& time = report["time"];
  const std::string pictures =
      report["video"] ? "recorded in motion"
                      : fmt::format("pictures {} ({} each)", duration(time["pictures_s"]),
                                    duration(time["one_station_s"]));
  return fmt::format("about {}: moving {}, settling {}, {}, placing the rail {}",
                     duration(time["total_s"]), duration(time["motion_s"]),
                     duration(time["settling_s"]), pictures, duration(time["placing_s"]));
}

std::string storage_text(const PlanJson& storage) {
  const std::string pictures = counted(storage["pictures"], "picture");
  if (storage["picture_mb"].is_null()) {
    return pictures +
           "; set run.picture_mb, or camera.width_px and height_px, "
           "to estimate their size";
  }
  const double each_mb = storage["picture_mb"];
  return fmt::format("about {}: {} of {}", size_text(each_mb * storage["pictures"].get<double>()),
                     pictures, size_text(each_mb));
}

std::string days_text(const PlanJson& work) {
  const std::string placements = counted(work["placements"], "placement") + " of the rail";
  if (work["hours_per_day"].is_null()) {
    return placements + "; set run.work_h_per_day to count the days";
  }
  const std::string hours = number(work["hours_per_day"], 1);
  if (work["days"].is_null()) {
    return fmt::format(
        "{}; the {} h of a day (run.work_h_per_day) do not "
        "suffice to home the slider and place "
        "the rail",
        placements, hours);
  }
  return fmt::format("{} of {} h, {}", counted(work["days"], "day"), hours, placements);
}

std::string cards_text(const PlanJson& work, bool video) {
  if (!work["uses_cards"]) return "none; the session's disk holds the pictures";
  if (video) return "not known: the size of videos is not estimated";
  if (work["card_gb"].is_null()) return "not known; set camera.card_gb to count them";
  if (work["cards"].is_null()) {
    return "not known; the size of a picture is not, or exceeds camera.card_gb";
  }
  return fmt::format("{} of {} GB for {} each; pictures stay on them until deleted",
                     counted(work["cards"], "card"), number(work["card_gb"], 1),
                     counted(work["pictures_per_card"], "picture"));
}

std::string batteries_text(const PlanJson& work) {
  if (work["battery_charges"].is_null()) {
    return "not known; set camera.battery_pictures or camera.battery_min to "
           "count charges";
  }
  const PlanJson& per_day = work["battery_charges_per_day"];
  return counted(work["battery_charges"], "charge") +
         (per_day.is_null() ? "" : fmt::format(", {} a day", per_day.get<int>()));
}

std::string spacing_text(const PlanJson& spacing) {
  if (spacing.is_null()) {
    return "set camera.width_px and height_px to estimate the resolution";
  }
  const std::string tolerance = number(spacing["tolerance_px"], 2);
  const std::string text = fmt::format(
      "without distances, resolves surfaces from {} m on within {} "
      "px of a panorama {} px wide\n",
      number(spacing["nearest_resolved_m"], 2), tolerance, spacing["panorama_width_px"].get<int>());
  if (spacing["ghost_px"].is_null()) {
    return text + "set scene.nearest_m to estimate the spacing that the scene needs";
  }
  const std::string needed = spacing["needed_mm"].is_null()
                                 ? "any spacing would do"
                                 : fmt::format("{} mm would keep it within {} px",
                                               number(spacing["needed_mm"], 2), tolerance);
  return text + fmt::format("the nearest surface doubles by {} px; {}",
                            number(spacing["ghost_px"], 2), needed);
}

}  // namespace

PlanJson plan_summary(const PlanJson& report) {
  const PlanJson& work = report["work"];
  return {{"lines", lines_text(report)},
          {"rail", rail_text(report["rail"])},
          {"overhang", overhang_text(report["overhang"])},
          {"time", time_text(report)},
          {"storage", storage_text(report["storage"])},
          {"days", days_text(work)},
          {"cards", cards_text(work, report["video"])},
          {"batteries", batteries_text(work)},
          {"spacing", spacing_text(report["spacing"])}};
}

std::string plan_report_text(const PlanJson& report) {
  std::string text;
  for (const auto& [name, lines] : report["summary"].items()) {
    std::istringstream in(lines.get<std::string>());
    std::string head = name + ":";
    for (std::string line; std::getline(in, line); head.clear()) {
      text += fmt::format("{:<11}{}\n", head, line);
    }
  }
  for (const PlanJson& warning : report["warnings"]) {
    text += "warning: " + warning.get<std::string>() + "\n";
  }
  return text;
}

}  // namespace raywalk::capture
