#include "core/judge/trade/trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <list>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/judge/trade/captured_views.h"
#include "core/judge/trade/held_out_views.h"
#include "core/judge/trade/measure_trade.h"
#include "core/judge/trade/trade_blocks.h"
#include "core/judge/trade/trade_json.h"
#include "core/judge/trade/trade_pictures.h"
#include "core/judge/trade/trade_sweep.h"
#include "core/room/requirements.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kQuickViews = 6;
constexpr std::size_t kFullHeldOutViews = 12;
constexpr int kQuickConnectViewpoints = 5;
constexpr int kFullConnectViewpoints = 13;

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

std::string write_trade(const TradeInput& input, const fs::path& report,
                        const BlockArguments& blocks) {
  prepare_report(report, input.rooms.front().room->directory());
  Trade trade;
  try {
    if (blocks.block) return measure_trade_block(input, report, *blocks.block);
    trade = blocks.merge ? merged_trade(input, report) : measure_trade(input, partial_file(report));
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining settings");
  }
  const std::vector<ReportImage> images = trade_images(trade, input.rooms);
  const nlohmann::ordered_json document = trade_document(trade);
  write_file_atomically(report / "trade.json", json_text(document));
  write_measured_settings(input.rooms.front().room->directory(), measured_settings(trade));
  write_file_atomically(report / "trade.csv", trade_csv(trade));
  write_file_atomically(report / "index.html", report_page("trade", document, images));
  fs::remove(partial_file(report));
  if (blocks.merge) remove_trade_blocks(report);
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
  std::optional<TimingLock> lock;
  if (!options.blocks.merge) {
    lock.emplace(options.timing_lock, "raywalk-render trade " + room.directory().string());
  }
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
  return write_trade(input, options.report, options.blocks);
}

}  // namespace raywalk
