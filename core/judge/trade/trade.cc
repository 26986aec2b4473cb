#include "core/judge/trade/trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <list>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json_text.h"
#include "core/files/sha256.h"
#include "core/judge/trade/captured_views.h"
#include "core/judge/trade/held_out_views.h"
#include "core/judge/trade/measure_setting.h"
#include "core/judge/trade/trade_json.h"
#include "core/judge/trade/trade_page.h"
#include "core/judge/trade/trade_partial.h"
#include "core/judge/trade/trade_sweep.h"
#include "core/judge/validation/validate.h"
#include "core/room/requirements.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kQuickViews = 6;
constexpr std::size_t kFullHeldOutViews = 12;
constexpr int kQuickConnectViewpoints = 5;
constexpr int kFullConnectViewpoints = 13;

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

// A key of everything that measurements depend on, except the settings.
std::string fingerprint_of(const TradeInput& input) {
  std::string text = fmt::format("{} {} {} {} {}\n", input.sweep, input.truth, input.repetitions,
                                 thread_count(), cpu_name());
  for (const TradeRoom& room : input.rooms) text += room_fingerprint(*room.room) + "\n";
  std::vector<TradeView> views = input.rooms.front().views;
  views.insert(views.end(), input.held_out.begin(), input.held_out.end());
  for (const TradeView& view : views) {
    text += fmt::format("{} {} {} {} {}\n", view.name, view.viewpoint.x_m, view.viewpoint.z_m,
                        sha256_of_pixels(view.truth), sha256_of_pixels(view.mask));
  }
  return sha256_hex(text);
}

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

std::vector<MeasuredSetting> measure_settings(const TradeInput& input, const fs::path& file) {
  TradePartial partial(file, fingerprint_of(input));
  std::vector<MeasuredSetting> settings;
  for (const TradeSetting& setting : input.settings) settings.push_back({.setting = setting});
  const auto left = std::ranges::count_if(
      input.settings, [&](const TradeSetting& setting) { return !partial.find(setting); });
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

// The generations (one mode of each) and the limit angles of a room's settings.
struct ConnectionsOfRoom {
  std::vector<ViewMode> modes{};
  std::set<double> k_list_deg{};
};

ConnectionsOfRoom connections_of(std::span<const MeasuredSetting> settings, std::size_t room) {
  ConnectionsOfRoom found;
  for (const MeasuredSetting& measured : settings) {
    if (measured.setting.room != room) continue;
    const ViewMode& mode = measured.setting.mode;
    found.k_list_deg.insert(mode.options.k_deg);
    const bool known = std::ranges::any_of(found.modes, [&](const ViewMode& other) {
      return other.options.generation == mode.options.generation;
    });
    if (!known) found.modes.push_back(mode);
  }
  return found;
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
void measure_connections(const TradeInput& input, std::vector<MeasuredSetting>* settings) {
  for (std::size_t room = 0; room < input.rooms.size(); ++room) {
    const ConnectionsOfRoom wanted = connections_of(*settings, room);
    if (wanted.modes.empty()) continue;
    const ConnectErrorOptions options{
        .viewpoints = input.connect_viewpoints,
        .k_list_deg = {wanted.k_list_deg.begin(), wanted.k_list_deg.end()}};
    for (const ConnectError& error :
         connection_errors(*input.rooms[room].room, wanted.modes, options)) {
      // Settings of unlike k are only comparable over the corners that all of these k can read.
      if (!(error.common_share >= kLeastCommonShare)) continue;
      for (const ConnectErrorRow& row : error.rows) give_connection_error(row, room, settings);
    }
  }
}

fs::path partial_file(const fs::path& report) { return report / "trade.partial.json"; }

void prepare_report(const fs::path& report, const fs::path& room) {
  make_directories(report);
  const AtomicFile room_probe(measured_settings_path(room));
  for (const char* name : {"trade.json", "trade.csv", "index.html", "trade.partial.json"}) {
    const AtomicFile probe(report / name);
  }
}

// A list, because views keep references to the rooms.
std::list<Room> open_others(const Room& room, const std::vector<fs::path>& directories) {
  std::list<Room> rooms;
  for (const fs::path& directory : directories) {
    rooms.push_back(Room::open(directory));
    require_same_lines(room, rooms.back());
  }
  return rooms;
}

// A room of the same width, depth and form as another is distinguished by its directory.
void make_depths_unique(std::vector<TradeRoom>* rooms) {
  std::set<std::tuple<int, std::string, std::string>> known;
  for (TradeRoom& room : *rooms) {
    const int width_px = room.room->panorama().width;
    const std::string compression = room.room->compression();
    if (known.emplace(width_px, room.depth, compression).second) continue;
    room.depth += ", " + room.room->directory().string();
    known.emplace(width_px, room.depth, compression);
  }
}

std::string agreement_text(const Trade& trade) {
  const RankAgreement agreement = rank_agreement(trade.settings);
  return fmt::format(
      "rank correlation of held-out stations with the truth over the settings: "
      "{:.3f} (PSNR), {:.3f} (WS-PSNR), {:.3f} (SSIM), {:.3f} (FSIM)\n",
      agreement.psnr_db, agreement.ws_psnr_db, agreement.ssim, agreement.fsim);
}

// What is said of times that are not to be relied on; empty where all are.
std::string disturbed_note(const Trade& trade) {
  const std::size_t count = disturbed_count(trade.settings);
  if (count == 0) return "";
  return fmt::format(
      "other programs disturbed the times of {} of {} settings: these are not to be relied on, and "
      "--budget-ms and --min-psnr-db choose none of them; run the same command again while nothing "
      "else runs\n",
      count, trade.settings.size());
}

std::string summary_of(const Trade& trade, const fs::path& report) {
  std::string text = fmt::format("{:>8}  {:>7}  {:>8}  {:>6}  {}\n", "ms", "x remap", "PSNR dB",
                                 "SSIM", "settings on the Pareto front");
  for (const std::size_t i : psnr_front(trade)) {
    const MeasuredSetting& setting = trade.settings[i];
    const TradeMeasurement& measured = setting.measured;
    text += fmt::format("{:8.2f}  {:7.2f}  {:8.2f}  {:6.4f}  {}\n", measured.time.ms,
                        measured.time.ratio, measured.scores.psnr_db, measured.scores.ssim,
                        marked_name(setting));
  }
  for (const TradedPreset& preset : trade.presets) {
    const TradeMeasurement& measured = trade.settings[preset.setting].measured;
    text += fmt::format("{:8.2f}  {:7.2f}  {:8.2f}  {:6.4f}  preset {}{}\n", measured.time.ms,
                        measured.time.ratio, measured.scores.psnr_db, measured.scores.ssim,
                        preset.name, measured.disturbed ? " (time disturbed)" : "");
  }
  text += disturbed_note(trade);
  if (!trade.held_out_views.empty()) text += agreement_text(trade);
  for (const TradedRoom& room : trade.rooms) {
    text += room.depth != kNoDepth
                ? fmt::format("{}: distances in use: {}\n", escaped(room.directory), room.depth)
                : escaped(room.directory) +
                      ": no distances, so only initial views were measured; estimate distances "
                      "with raywalk-build-lf depth\n";
  }
  return text + escaped((report / "index.html").string());
}

// Presets use all threads and the truths' width; those that are not in the sweep are added to it.
void add_presets(const std::vector<NamedMode>& presets, const SweepBase& base, TradeInput* input) {
  for (const NamedMode& preset : presets) {
    TradeSetting setting{.name = "preset " + preset.name,
                         .mode = preset.mode,
                         .threads = base.threads,
                         .stored_width_px = input->rooms.front().room->panorama().width,
                         .depth = input->rooms.front().depth,
                         .compression = input->rooms.front().room->compression()};
    setting.mode.options.width = base.width_px;
    const auto alike = std::ranges::find_if(input->settings, [&](const TradeSetting& other) {
      return parameters_of(other) == parameters_of(setting);
    });
    const auto index = static_cast<std::size_t>(alike - input->settings.begin());
    if (alike == input->settings.end()) input->settings.push_back(setting);
    input->presets.push_back({preset.name, preset.reason, index});
  }
}

}  // namespace

MeasuredSettings measured_settings(const Trade& trade) {
  static_assert(kMostPsnr_db == kMaxPsnrDb, "written scores have to be readable");
  MeasuredSettings measured{.distances_sha256 = trade.distances_sha256, .width_px = trade.width_px};
  for (const MeasuredSetting& setting : trade.settings) {
    if (setting.setting.room != 0 || setting.setting.threads != trade.threads) continue;
    measured.choices.push_back({.name = setting.setting.name,
                                .options = setting.setting.mode.options,
                                .ratio = setting.measured.time.ratio,
                                .psnr_db = setting.measured.scores.psnr_db,
                                .disturbed = setting.measured.disturbed});
  }
  return measured;
}

Trade measure_trade(const TradeInput& input, const fs::path& partial) {
  const TradeRoom& main = input.rooms.front();
  Trade trade{.truth = input.truth,
              .sweep = input.sweep,
              .distances_sha256 = distances_sha256(*main.room),
              .width_px = main.views.front().truth.cols,
              .threads = thread_count(),
              .cpu = cpu_name(),
              .repetitions = input.repetitions,
              .connect_viewpoints = input.connect_viewpoints};
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
  try {
    trade.settings = measure_settings(input, partial);
    measure_connections(input, &trade.settings);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining settings");
  }
  std::vector<double> remap_ms;
  for (const MeasuredSetting& setting : trade.settings) {
    remap_ms.push_back(setting.measured.time.remap_ms);
  }
  trade.remap_ms = median(remap_ms);
  find_fronts(&trade.settings);
  return trade;
}

std::string write_trade(const TradeInput& input, const fs::path& report) {
  prepare_report(report, input.rooms.front().room->directory());
  const Trade trade = measure_trade(input, partial_file(report));
  const TradePictures pictures = trade_pictures(trade, input.rooms);
  const nlohmann::ordered_json document = trade_document(trade);
  write_file_atomically(report / "trade.json", json_text(document));
  write_measured_settings(input.rooms.front().room->directory(), measured_settings(trade));
  write_file_atomically(report / "trade.csv", trade_csv(trade));
  write_file_atomically(report / "index.html", trade_page(document, pictures));
  fs::remove(partial_file(report));
  return summary_of(trade, report);
}

std::string trade(const Room& room, const TradeOptions& options) {
  if (options.truth.empty() && options.held_out == 0) {
    throw UsageError("give true views with --truth, or use stations as true views with --held-out");
  }
  if (options.held_out > 0 && !options.also.empty()) {
    throw UsageError(
        "--held-out renders stations of one room; --also needs --truth without --held-out");
  }
  const std::list<Room> others = open_others(room, options.also);
  std::vector<TradeView> views;
  if (!options.truth.empty()) {
    const std::vector<TruthView> truths = read_truth(options.truth, room);
    views = captured_views(room, truths, options.full ? truths.size() : kQuickViews);
  }
  prepare_report(options.report, room.directory());  // before minutes of waiting and estimating
  // Estimating distances without the held-out stations would disturb others as well.
  const TimingLock lock(options.timing_lock, "raywalk-render trade " + room.directory().string());
  HeldOutViews held_out;
  if (options.held_out > 0) {
    held_out =
        held_out_views(room, options.held_out, options.full ? kFullHeldOutViews : kQuickViews);
  }
  const std::string held_out_text = fmt::format("one of {} stations, held out", options.held_out);
  TradeInput input{
      .truth = options.truth.empty() ? held_out_text : options.truth.string(),
      .sweep = options.full ? "full" : "quick",
      .repetitions = options.repetitions,
      .connect_viewpoints = options.full ? kFullConnectViewpoints : kQuickConnectViewpoints};
  if (options.truth.empty()) {
    input.rooms.push_back({&room, depth_name(room), held_out.views});
  } else {
    input.rooms.push_back(trade_room(room, views));
    input.held_out = held_out.views;
  }
  for (const Room& other : others) input.rooms.push_back(trade_room(other, views));
  make_depths_unique(&input.rooms);
  const SweepBase base{.centres = options.centres,
                       .rooms = input.rooms,
                       .width_px = input.rooms.front().views.front().truth.cols,
                       .threads = thread_count()};
  input.settings = options.full ? full_sweep(base) : quick_sweep(base);
  add_presets(options.presets, base, &input);
  return write_trade(input, options.report);
}

}  // namespace raywalk
