// The work of `raywalk-render trade`: measures many settings of the rendering parameters against
// ground truth and finds the Pareto front of time and accuracy.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/evaluate/measured_settings.h"
#include "core/evaluate/trade_sweep.h"
#include "core/evaluate/truth_views.h"
#include "core/room/room.h"

namespace raywalk {

// A preset for the room.
struct NamedOptions {
  std::string name{};
  std::string reason{};  // explanation for the user
  ViewOptions options{};
};

struct TradeOptions {
  std::filesystem::path truth{};   // gt.csv
  int held_out = 0;                // instead of it: every n-th station is held out as a true view
  std::filesystem::path report{};  // directory, created if it is missing
  int repetitions = 3;
  // The central setting of every generation that the room can be rendered in.
  std::vector<ViewOptions> centres{};
  std::vector<NamedOptions> presets{};
};

// Reads the truths, checks that the report can be written, then measures and writes as below.
// Throws Error before any rendering where the input is wrong or the report cannot be written.
std::string trade(const Room& room, const TradeOptions& options);

// What is measured.
struct TradeInput {
  const Room* room = nullptr;           // that the settings are for
  const Room* rendered_from = nullptr;  // the same, or without stations that were held out
  std::string truth{};                  // the source of the views, for the report
  std::vector<TrueView> views{};        // of one width
  std::vector<TradeSetting> settings{};
  std::vector<NamedOptions> presets{};  // each is among the settings, at the width of the views
  int repetitions = 3;
  TimeSource time_source = wall_time_s;
};

// Measures every setting (measure_setting.h) and writes `report`/trade.json (docs/file-formats.md
// lists its keys), trade.csv and index.html, each atomically, and the room's measured settings, by
// which views are chosen. A stopped run leaves what it measured in `report`/trade.partial, and the
// same call resumes it. Returns a summary for the user. Throws Error as Renderer does and where a
// file cannot be written; Interrupted.
std::string write_trade(const TradeInput& input, const std::filesystem::path& report);

}  // namespace raywalk
