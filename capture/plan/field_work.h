// What a capture takes on the spot: days, storage cards and charges of the camera's battery.
//
// The facts about place and camera are settings. Where the configuration does not give one, what
// follows from it is unknown; nothing is assumed.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/plan/capture_plan.h"
#include "capture/plan/capture_time.h"

namespace raywalk::capture {

struct FieldWork {
  std::size_t placements = 0;  // of the rail, of all lines
  double hours_per_day = 0.0;  // run.work_h_per_day; 0: unknown
  double day_starts_s = 0.0;   // homing and placing the rail, on every day but the first
  // None if the hours of a day are unknown, or too few to begin a day.
  std::optional<std::int64_t> days{};

  bool has_card = true;  // the camera stores its pictures on a card
  bool film = false;     // run.mode video: the size of films is not estimated
  double card_gb = 0.0;  // camera.card_gb; 0: unknown
  std::int64_t pictures_per_card = 0;
  std::optional<std::int64_t> cards{};  // none if sizes of card or pictures are unknown

  // None if neither camera.battery_pictures nor camera.battery_min is known.
  std::optional<std::int64_t> battery_charges{};
  double battery_changes_s = 0.0;  // all changes of the battery

  // Charges on a day; none if charges or days are unknown.
  std::optional<std::int64_t> charges_per_day() const;
};

// `pictures` and `picture_mb` of the whole plan and of one exposure, 10^6 bytes; none: unknown.
FieldWork field_work(const CapturePlan& plan, const CaptureConfig& config, const CaptureTime& time,
                     std::size_t pictures, const std::optional<double>& picture_mb);

// Lines of text.
std::string field_work_text(const FieldWork& work);
// The members above with units in the names, null for what is unknown.
nlohmann::json field_work_json(const FieldWork& work);

}  // namespace raywalk::capture
