// Settings chosen by what `raywalk-render trade` measured on the room: `--budget-ms` and
// `--min-psnr-db`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_time.h"
#include "render/presets.h"

namespace raywalk::render {

// One setting measured by a trade.
struct MeasuredChoice {
  std::string name{};
  ViewSettings settings{};
  double ratio = 0.0;  // its time per view divided by that of one cv::remap of the same size
  double psnr_db = 0.0;
  bool disturbed = false;  // its time is not to be relied on
};

// The part of a trade that settings are chosen from: those of the room itself, on all threads.
struct MeasuredTrade {
  std::string distances_sha256{};  // distances_sha256() of the room it was measured on
  int width_px = 0;                // of the pictures that were compared
  std::vector<MeasuredChoice> choices{};
};

// Parses trade.json; `source` names it in errors. Throws Error where the text is not a trade.json
// of a known version, or holds no setting of the room itself.
MeasuredTrade measured_trade_from_json(const std::string& text, const std::string& source);

// What a view has to satisfy.
struct Demand {
  std::optional<double> budget_ms{};    // per panorama
  std::optional<double> min_psnr_db{};  // against the truth of the trade
};

// Throws UsageError for numbers that nobody can mean: NaN, infinite or out of range.
void require_demand(const Demand& demand);

// The setting that meets a demand, of which at least one member is set: with a minimum PSNR the
// fastest setting that reaches it, else the most accurate one within the budget. The time of a
// setting is its measured ratio times `remap_ms`, the time of cv::remap on this machine. Settings
// with disturbed times are never chosen. Throws Error where no setting meets the demand; the
// message names the nearest one.
Preset choose_setting(const MeasuredTrade& trade, const Demand& demand, double remap_ms);

// view_settings() on top of the choice from the room's own trade.json. Throws Error where the room
// has no trade.json or one measured with other distances, and as choose_setting() does.
Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room,
                         const TimeSource& source = {});

}  // namespace raywalk::render
