// Settings chosen by what `raywalk-render trade` measured on the room: `--budget-ms` and
// `--min-psnr-db`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "render/presets.h"

namespace raywalk::render {

// What a measured trade says of one setting.
struct MeasuredChoice {
  std::string name{};
  ViewSettings settings{};
  double ratio = 0.0;  // of its time per view to one cv::remap of the same size
  double psnr_db = 0.0;
};

// A trade as far as choosing goes: the settings of the room itself, on all threads.
struct MeasuredTrade {
  std::string distances_sha256{};  // of the room it was measured on: distances_sha256()
  int width_px = 0;                // of the pictures that were compared
  std::vector<MeasuredChoice> choices{};
};

// Parses trade.json; `source` names it in errors. Throws Error for anything else.
MeasuredTrade measured_trade_from_json(const std::string& text, const std::string& source);

struct Demand {
  std::optional<double> budget_ms{};    // per panorama
  std::optional<double> min_psnr_db{};  // against the truth of the trade
};

// The choice of a demand, of which at least one part is given: with a least PSNR the cheapest that
// reaches it, else the best within the budget. A time is the measured ratio times `remap_ms`, what
// cv::remap takes here and now. Throws Error where none meets the demand, saying what the best
// does.
Preset choose_setting(const MeasuredTrade& trade, const Demand& demand, double remap_ms);

// view_settings() on top of what the room's own trade.json gives for the demand. Throws Error where
// the room has none or one of other distances, or as choose_setting() does.
Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room);

}  // namespace raywalk::render
