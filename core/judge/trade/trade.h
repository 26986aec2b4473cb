// The work of `raywalk-render trade`: measures many settings of the rendering parameters against
// ground truth and finds the Pareto front of time and accuracy.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/base/block.h"
#include "core/judge/trade/measured_settings.h"
#include "core/judge/trade/timing_lock.h"
#include "core/judge/trade/trade_input.h"
#include "core/judge/trade/trade_result.h"
#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk {

// A preset for the room.
struct NamedMode {
  std::string name{};
  std::string reason{};  // explanation for the user
  ViewMode mode{};
};

struct TradeOptions {
  std::filesystem::path truth{};              // gt.csv; empty: held-out stations are the truth
  int held_out = 0;                           // every n-th station is held out; 0 disables
  std::filesystem::path report{};             // directory, created if it is missing
  std::vector<std::filesystem::path> also{};  // other rooms of the same place
  bool full = false;
  int repetitions = 3;
  std::filesystem::path timing_lock = machine_timing_lock();
  // The central setting of every generation that the room can be rendered in.
  std::vector<ViewMode> centres{};
  std::vector<NamedMode> presets{};
  BlockArguments blocks{};
};

// What settings are chosen by: those of the room itself, on all threads.
MeasuredSettings measured_settings(const Trade& trade);

// Measures, and writes `report`/trade.json, trade.csv and index.html (each atomically) and the
// measured settings of the first room. A block is measured alone and kept for the run that merges
// (trade_blocks.h). Returns a summary for the user.
std::string write_trade(const TradeInput& input, const std::filesystem::path& report,
                        const BlockArguments& blocks = {});

// Reads the truths, opens the rooms, checks that the report can be written, waits for the timing
// lock (timing_lock.h) unless it only merges, then measures and writes as above. Returns a summary
// for the user. Throws Error before any rendering where the input is wrong or the report cannot be
// written.
std::string trade(const Room& room, const TradeOptions& options);

}  // namespace raywalk
