// The work of `raywalk-render trade`: measures many settings of the rendering parameters against
// ground truth and finds the Pareto front of time and accuracy.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/evaluate/trade/measure_setting.h"
#include "core/evaluate/trade/measured_settings.h"
#include "core/evaluate/trade/trade_sweep.h"
#include "core/evaluate/trade/trade_views.h"
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
  std::filesystem::path truth{};   // gt.csv
  int held_out = 0;                // instead of it: every n-th station is held out as a true view
  std::filesystem::path report{};  // directory, created if it is missing
  int repetitions = 3;
  // The central setting of every generation that the room can be rendered in.
  std::vector<ViewMode> centres{};
  std::vector<NamedMode> presets{};
};

// What is measured.
struct TradeInput {
  const Room* room = nullptr;
  std::string truth{};  // the source of the views, for the report
  std::vector<TradeView> views{};
  std::vector<TradeSetting> settings{};
  std::vector<NamedMode> presets{};  // each is among the settings, by parameters
  int repetitions = 3;
  int connect_viewpoints = 5;  // per side of a cell, for e_connect
  TimeSource time_source = wall_time_s;
};

struct MeasuredSetting {
  TradeSetting setting{};
  TradeMeasurement measured{};
  // Equation (11) at the setting's generation and k, in squared 8-bit levels, over the corners that
  // are readable at every k of the sweep; NaN: these are too few (kLeastCommonShare).
  double e_connect = std::numeric_limits<double>::quiet_NaN();
  // Whether no other setting is at least as good in ratio and PSNR and better in one.
  bool on_front = false;
};

// Measures every setting. Finished settings are kept in the file `partial`; those already there for
// the same input are not measured again. The file is not removed. Prints progress. Throws Error
// where `partial` is damaged or belongs to another input or processor; Interrupted.
std::vector<MeasuredSetting> measure_trade(const TradeInput& input,
                                           const std::filesystem::path& partial);

// Measures, and writes `report`/trade.json, trade.csv and index.html (each atomically) and the
// room's measured settings, by which views are chosen. Returns a summary for the user.
std::string write_trade(const TradeInput& input, const std::filesystem::path& report);

// Reads the truths, checks that the report can be written, then measures and writes as above.
// Throws Error before any rendering where the input is wrong or the report cannot be written.
std::string trade(const Room& room, const TradeOptions& options);

}  // namespace raywalk
