// The work of `raywalk-render trade`: many settings of the parameters of rendering, each measured
// against ground truth, and which of them are worth having.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "render/trade/trade_result.h"
#include "render/trade/trade_setting.h"
#include "render/trade/trade_view.h"
#include "render/validation/view_mode.h"

namespace raywalk::render {

// A ready-made setting for the room.
struct NamedMode {
  std::string name{};
  std::string reason{};  // why it is as it is, in words
  ViewMode mode{};
};

struct TradeOptions {
  std::filesystem::path truth{};              // gt.csv; empty: held-out stations are the truth
  int held_out = 0;                           // one of so many stations is rendered again; 0: none
  std::filesystem::path report{};             // directory, made if it is missing
  std::vector<std::filesystem::path> also{};  // the same place packed otherwise
  bool full = false;
  int repetitions = 3;
  // The central setting of every generation that the room can be rendered in.
  std::vector<ViewMode> centres{};
  std::vector<NamedMode> presets{};
};

// What is measured, whatever its truths come from.
struct TradeInput {
  std::vector<TradeRoom> rooms{};  // the one that the trade is about first; at least one view each
  std::string truth{};             // where the truths come from, for the report
  std::string sweep = "quick";     // "quick" or "full"
  std::vector<TradeSetting> settings{};
  std::vector<TradeView> held_out{};    // scored besides the rooms' views, where there are any
  std::vector<TradedPreset> presets{};  // among the settings
  int repetitions = 3;
  int connect_viewpoints = 5;  // per side of a cell, for e_connect
};

// Measures every setting. What is finished is kept in `partial`, and what is there already from the
// same input is not measured again; the file stays (write_trade's caller removes it). Prints
// progress. Throws Error where `partial` is damaged or belongs to another input; Interrupted.
Trade measure_trade(const TradeInput& input, const std::filesystem::path& partial);

// Where a room keeps the last trade that was measured on it, a copy of trade.json.
std::filesystem::path trade_path(const std::filesystem::path& room);

// Measures, and writes `report`/trade.json, trade.csv and index.html, each complete when it
// appears; and trade_path() of the first room.
std::string write_trade(const TradeInput& input, const std::filesystem::path& report);

// Reads or renders around the truths, opens the rooms, checks that the report can be written, and
// does the above. Returns what to tell the user. Throws Error before any rendering where the input
// or the report's place is wrong.
std::string trade(const Room& room, const TradeOptions& options);

}  // namespace raywalk::render
