#include "capture/plan/field_work.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/report/markup.h"

namespace raywalk::capture {
namespace {

constexpr double kSecondsPerMinute = 60.0;
constexpr double kSecondsPerHour = 3600.0;
constexpr double kMegabytesPerGigabyte = 1000.0;

std::int64_t rounded_up(double parts) { return static_cast<std::int64_t>(std::ceil(parts)); }

// A charge ends at the first of the two limits, so the larger number of charges counts.
std::optional<std::int64_t> charges(const CaptureConfig& config, const CaptureTime& time,
                                    std::size_t pictures) {
  const CameraConfig& camera = config.camera;
  std::optional<std::int64_t> needed;
  if (camera.battery_pictures > 0 && config.run.mode == CaptureMode::kStations) {
    needed = rounded_up(static_cast<double>(pictures) / camera.battery_pictures);
  }
  if (camera.battery_min > 0.0) {
    const std::int64_t by_time =
        rounded_up(time.total_s() / (camera.battery_min * kSecondsPerMinute));
    needed = std::max(needed.value_or(0), by_time);
  }
  return needed;
}

// Every day but the first begins with homing and with placing the rail where it was the evening
// before: the estimated time has both once already.
std::optional<std::int64_t> days_of(const FieldWork& work, double total_s) {
  const double day_s = work.hours_per_day * kSecondsPerHour;
  if (day_s <= 0.0) return std::nullopt;
  if (total_s <= day_s) return 1;
  if (day_s <= work.day_starts_s) return std::nullopt;
  return 1 + rounded_up((total_s - day_s) / (day_s - work.day_starts_s));
}

void count_cards(const std::optional<double>& picture_mb, std::size_t pictures, FieldWork* work) {
  if (!work->has_card || work->film || !picture_mb || work->card_gb == 0.0) return;
  work->pictures_per_card =
      static_cast<std::int64_t>(work->card_gb * kMegabytesPerGigabyte / *picture_mb);
  if (work->pictures_per_card == 0) return;  // a card smaller than a picture
  work->cards = rounded_up(static_cast<double>(pictures) / work->pictures_per_card);
}

std::string days_text(const FieldWork& work) {
  const std::string placements = counted(work.placements, "placement") + " of the rail";
  if (work.hours_per_day == 0.0) {
    return fmt::format("days:      {}; set run.work_h_per_day to count the days\n", placements);
  }
  const std::string hours = plain_number(work.hours_per_day, 1);
  if (!work.days) {
    return fmt::format(
        "days:      {}; the {} h of a day (run.work_h_per_day) do not suffice to home the slider "
        "and place the rail\n",
        placements, hours);
  }
  return fmt::format("days:      {} of {} h, {}\n",
                     counted(static_cast<std::size_t>(*work.days), "day"), hours, placements);
}

std::string cards_text(const FieldWork& work) {
  if (!work.has_card) return "cards:     none; the session's disk holds the pictures\n";
  if (work.film) return "cards:     not known: the size of films is not estimated\n";
  if (work.card_gb == 0.0) return "cards:     not known; set camera.card_gb to count them\n";
  if (!work.cards) {
    return "cards:     not known; the size of a picture is not, or exceeds camera.card_gb\n";
  }
  return fmt::format("cards:     {} of {} GB for {} each; pictures stay on them until deleted\n",
                     counted(static_cast<std::size_t>(*work.cards), "card"),
                     plain_number(work.card_gb, 1),
                     counted(static_cast<std::size_t>(work.pictures_per_card), "picture"));
}

std::string batteries_text(const FieldWork& work) {
  if (!work.battery_charges) {
    return "batteries: not known; set camera.battery_pictures or camera.battery_min to count "
           "charges\n";
  }
  std::string text = fmt::format(
      "batteries: {}", counted(static_cast<std::size_t>(*work.battery_charges), "charge"));
  if (const auto per_day = work.charges_per_day()) text += fmt::format(", {} a day", *per_day);
  return text + "\n";
}

nlohmann::json or_null(const std::optional<std::int64_t>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json known_or_null(double value) {
  return value > 0.0 ? nlohmann::json(value) : nlohmann::json();
}

}  // namespace

std::optional<std::int64_t> FieldWork::charges_per_day() const {
  if (!battery_charges || !days) return std::nullopt;
  return (*battery_charges + *days - 1) / *days;
}

FieldWork field_work(const CapturePlan& plan, const CaptureConfig& config, const CaptureTime& time,
                     std::size_t pictures, const std::optional<double>& picture_mb) {
  FieldWork work;
  work.placements = placements_of(plan).size();
  work.hours_per_day = config.run.work_h_per_day;
  work.day_starts_s = homing_s(config) + config.run.placing_s;
  work.has_card = config.camera.kind != CameraKind::kV4l2;
  work.film = config.run.mode == CaptureMode::kVideo;
  work.card_gb = config.camera.card_gb;
  count_cards(picture_mb, pictures, &work);
  work.battery_charges = charges(config, time, pictures);
  const std::int64_t changes = std::max<std::int64_t>(work.battery_charges.value_or(1) - 1, 0);
  work.battery_changes_s = static_cast<double>(changes) * config.run.battery_change_s;
  work.days = days_of(work, time.total_s() + work.battery_changes_s);
  return work;
}

std::string field_work_text(const FieldWork& work) {
  return days_text(work) + cards_text(work) + batteries_text(work);
}

nlohmann::json field_work_json(const FieldWork& work) {
  return {
      {"placements", work.placements},
      {"hours_per_day", known_or_null(work.hours_per_day)},
      {"days", or_null(work.days)},
      {"uses_cards", work.has_card},
      {"card_gb", known_or_null(work.card_gb)},
      {"pictures_per_card", work.cards ? nlohmann::json(work.pictures_per_card) : nlohmann::json()},
      {"cards", or_null(work.cards)},
      {"battery_charges", or_null(work.battery_charges)},
      {"battery_charges_per_day", or_null(work.charges_per_day())},
      {"battery_changes_s", work.battery_changes_s}};
}

}  // namespace raywalk::capture
