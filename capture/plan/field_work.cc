// The facts about place and camera are settings. Where the configuration does not give one, what
// follows from it is unknown; nothing is assumed.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "capture/plan/plan_report.h"

namespace raywalk::capture {
namespace {

constexpr double kSecondsPerMinute = 60.0;
constexpr double kSecondsPerHour = 3600.0;
constexpr double kMegabytesPerGigabyte = 1000.0;

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

// 0: unknown, or a card is smaller than a picture. The size of films is not estimated.
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

}  // namespace

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

}  // namespace raywalk::capture
