// Settings chosen by what `raywalk-render trade` measured on the room: `--budget-ms` and
// `--min-psnr-db`.
#pragma once

#include <optional>

#include "core/evaluate/measured_settings.h"
#include "core/room/room.h"
#include "render/view/presets.h"

namespace raywalk::render {

// What a view has to satisfy.
struct Demand {
  std::optional<double> budget_ms{};    // per panorama
  std::optional<double> min_psnr_db{};  // against the truth of the trade
};

// Throws UsageError for numbers that nobody can mean: NaN, infinite or out of range.
void require_demand(const Demand& demand);

// The setting that meets a demand, of which at least one member is set: with a minimum PSNR the
// fastest setting that reaches it, else the most accurate one within the budget. The time of a
// setting is its measured ratio times `remap_ms`, the time of cv::remap on this machine. Throws
// Error where no setting meets the demand; the message names the nearest one.
Preset choose_setting(const MeasuredSettings& measured, const Demand& demand, double remap_ms);

// view_settings() on top of the choice from the room's own measured settings. Throws Error where
// the room has none or they were measured with other distances, and as choose_setting() does.
Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room,
                         const TimeSource& source = wall_time_s);

// demanded_settings() where anything is demanded, else preset_settings().
Preset settings_for(const ViewFlags& flags, const Demand& demand, const Room& room);

// The mode of views with these settings.
ViewMode mode_of(const Preset& chosen);

}  // namespace raywalk::render
