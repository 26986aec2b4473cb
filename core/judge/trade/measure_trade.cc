#include "core/judge/trade/measure_trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/fingerprint.h"
#include "core/files/sha256.h"
#include "core/judge/trade/measure_setting.h"
#include "core/judge/trade/trade_partial.h"
#include "core/judge/validation/validate.h"
#include "core/room/requirements.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Measures again what other programs disturbed, and marks what stays disturbed.
void settle_disturbed(const TradeInput& input, const ViewTimer& timer, TradePartial* partial,
                      std::vector<MeasuredSetting>* settings) {
  std::vector<ViewTime> times;
  for (const MeasuredSetting& setting : *settings) times.push_back(setting.measured.time);
  std::optional<Progress> progress;
  const auto begin_round = [&](std::ptrdiff_t count) {
    progress.emplace("disturbed, timed again", count, "settings");
  };
  const auto measure = [&](std::size_t i) {
    const TradeSetting& setting = (*settings)[i].setting;
    const ViewTime time = measure_time(setting, input.rooms[setting.room].views, timer);
    progress->advance();
    return time;
  };
  repeat_disturbed(&times, begin_round, measure, [&](std::size_t i) {
    (*settings)[i].measured.time = times[i];
    partial->add((*settings)[i].setting, (*settings)[i].measured);
  });
  const std::vector<bool> marked = disturbed(times);
  for (std::size_t i = 0; i < times.size(); ++i) (*settings)[i].measured.disturbed = marked[i];
}

void give_connection_error(const ConnectErrorRow& row, std::size_t room,
                           std::vector<MeasuredSetting>* settings) {
  for (MeasuredSetting& measured : *settings) {
    const ViewOptions& options = measured.setting.mode.options;
    if (measured.setting.room != room || options.k_deg != row.k_deg) continue;
    if (options.generation == row.generation) measured.measured.e_connect = row.e_connect_common;
  }
}

// The connection error of every room at each generation and k of its settings; the other parameters
// hardly change it.
void find_connections(const TradeInput& input, const std::optional<fs::path>& kept_in,
                      std::vector<MeasuredSetting>* settings) {
  for (std::size_t room = 0; room < input.rooms.size(); ++room) {
    const WantedConnections wanted = wanted_connections(input, room);
    if (wanted.modes.empty()) continue;
    const auto kept = kept_in ? std::optional(*kept_in / std::to_string(room)) : std::nullopt;
    for (const ConnectError& error :
         connection_errors(*input.rooms[room].room, wanted.modes, wanted.options, kept)) {
      // Settings of unlike k are only comparable over the corners that all of these k can read.
      if (!(error.common_share >= kLeastCommonShare)) continue;
      for (const ConnectErrorRow& row : error.rows) give_connection_error(row, room, settings);
    }
  }
}

}  // namespace

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string inputs_text(const TradeInput& input) {
  std::string text = fmt::format("{} {} {} {} {}\n", input.sweep, input.truth, input.repetitions,
                                 thread_count(), input.connect_viewpoints);
  for (const TradeRoom& room : input.rooms) text += room_fingerprint(*room.room) + "\n";
  std::vector<TradeView> views = input.rooms.front().views;
  views.insert(views.end(), input.held_out.begin(), input.held_out.end());
  for (const TradeView& view : views) {
    const std::string height = view.height_m ? fmt::format("{}", *view.height_m) : "";
    text +=
        fmt::format("{} {} {} {} {} {}\n", view.name, view.viewpoint.x_m, height,
                    view.viewpoint.z_m, sha256_of_pixels(view.truth), sha256_of_pixels(view.mask));
  }
  return text;
}

std::vector<MeasuredSetting> measure_settings(const TradeInput& input, IndexRange range,
                                              const fs::path& file) {
  std::vector<MeasuredSetting> settings;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    settings.push_back({.setting = input.settings[i]});
  }
  if (settings.empty()) return settings;
  TradePartial partial(file, sha256_hex(inputs_text(input) + cpu_name()));
  const auto left = std::ranges::count_if(
      settings, [&](const MeasuredSetting& measured) { return !partial.find(measured.setting); });
  PitchRemap yardstick(input.rooms.front().views.front().truth.cols);
  const ViewTimer timer{input.repetitions, &yardstick, input.time_source};
  {
    Progress progress("trade", left, "settings");
    for (MeasuredSetting& measured : settings) {
      const TradeSetting& setting = measured.setting;
      if (const auto found = partial.find(setting)) {
        measured.measured = *found;
        continue;
      }
      measured.measured = measure_setting(setting, input.rooms[setting.room].views, timer);
      if (!input.held_out.empty()) {
        measured.measured.held_out = score_setting(setting, input.held_out);
      }
      partial.add(setting, measured.measured);
      progress.advance();
    }
  }
  settle_disturbed(input, timer, &partial, &settings);
  return settings;
}

WantedConnections wanted_connections(const TradeInput& input, std::size_t room) {
  WantedConnections wanted;
  std::set<double> k_list_deg;
  for (const TradeSetting& setting : input.settings) {
    if (setting.room != room) continue;
    const ViewMode& mode = setting.mode;
    k_list_deg.insert(mode.options.k_deg);
    const bool known = std::ranges::any_of(wanted.modes, [&](const ViewMode& other) {
      return other.options.generation == mode.options.generation;
    });
    if (!known) wanted.modes.push_back(mode);
  }
  wanted.options = {.viewpoints = input.connect_viewpoints,
                    .k_list_deg = {k_list_deg.begin(), k_list_deg.end()}};
  return wanted;
}

Trade completed_trade(const TradeInput& input, std::vector<MeasuredSetting> settings,
                      std::string cpu, const std::optional<fs::path>& kept_in) {
  const TradeRoom& main = input.rooms.front();
  Trade trade{.truth = input.truth,
              .sweep = input.sweep,
              .distances_sha256 = distances_sha256(*main.room),
              .width_px = main.views.front().truth.cols,
              .threads = thread_count(),
              .cpu = std::move(cpu),
              .repetitions = input.repetitions,
              .connect_viewpoints = input.connect_viewpoints,
              .settings = std::move(settings)};
  for (const TradeRoom& room : input.rooms) {
    trade.rooms.push_back({.directory = room.room->directory().string(),
                           .stored_width_px = room.room->panorama().width,
                           .depth = room.depth,
                           .compression = room.room->compression(),
                           .rays_mb = 1e-6 * static_cast<double>(room.room->ray_file_bytes())});
  }
  for (const TradeView& view : main.views) trade.views.push_back(view.name);
  for (const TradeView& view : input.held_out) trade.held_out_views.push_back(view.name);
  trade.presets = input.presets;
  find_connections(input, kept_in, &trade.settings);
  std::vector<double> remap_ms;
  for (const MeasuredSetting& setting : trade.settings) {
    remap_ms.push_back(setting.measured.time.remap_ms);
  }
  trade.remap_ms = median(remap_ms);
  find_fronts(&trade.settings);
  return trade;
}

Trade measure_trade(const TradeInput& input, const fs::path& partial) {
  return completed_trade(input, measure_settings(input, {0, input.settings.size()}, partial),
                         cpu_name());
}

}  // namespace raywalk
