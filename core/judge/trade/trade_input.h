// What a trade measures.
#pragma once

#include <string>
#include <vector>

#include "core/judge/trade/trade_result.h"
#include "core/judge/trade/trade_setting.h"
#include "core/judge/trade/trade_view.h"

namespace raywalk {

// For captured and held-out truths alike.
struct TradeInput {
  std::vector<TradeRoom> rooms{};  // the room under test first; at least one view each
  std::string truth{};             // the source of the truths, for the report
  std::string sweep = "quick";     // "quick" or "full"
  std::vector<TradeSetting> settings{};
  std::vector<TradeView> held_out{};    // scored in addition to the rooms' views; may be empty
  std::vector<TradedPreset> presets{};  // among the settings
  int repetitions = 3;
  int connect_viewpoints = 5;  // per side of a cell, for e_connect
  TimeSource time_source{};
};

}  // namespace raywalk
