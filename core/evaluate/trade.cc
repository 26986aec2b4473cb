#include "core/evaluate/trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/evaluate/held_out_views.h"
#include "core/evaluate/kept_results.h"
#include "core/evaluate/measure_setting.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"
#include "core/report/report.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kTradeFormatVersion = 6;
constexpr std::size_t kViews = 6;
// The remap does the same work every time: where its upper quartile is above its least time by more
// than this part, other programs were busy, and times are less certain.
constexpr double kBusySpread = 0.25;

// The name of this machine's processor.
std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

// Everything that measurements depend on, except the settings.
std::string fingerprint_of(const TradeInput& input) {
  std::string text = fmt::format("trade {} {} {} {}\n", input.repetitions, thread_count(),
                                 cpu_name(), room_fingerprint(*input.room));
  for (const TrueView& view : input.views) {
    text += fmt::format("{} {} {} {} {} {}\n", view.name, view.viewpoint.x_m,
                        view.height_m.value_or(0.0), view.viewpoint.z_m,
                        sha256_of_pixels(view.image), sha256_of_pixels(view.mask));
  }
  return text;
}

// Of trade.json: each setting's parameters and what was measured of it. What an earlier run
// measured is not measured again.
std::vector<ordered_json> measured_rows(const TradeInput& input, KeptResults* kept) {
  const std::string fingerprint = fingerprint_of(input);
  std::vector<std::string> keys;
  for (const TradeSetting& setting : input.settings) {
    keys.push_back(sha256_hex(fingerprint + parameters_of(setting).dump()));
  }
  const SettingMeasurement measurement{.room = *input.rendered_from,
                                       .views = input.views,
                                       .repetitions = input.repetitions,
                                       .time_source = input.time_source};
  const auto left =
      std::ranges::count_if(keys, [&](const auto& key) { return kept->find(key) == nullptr; });
  Progress progress("trade", left, "settings");
  std::vector<ordered_json> rows;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const TradeSetting& setting = input.settings[i];
    if (kept->find(keys[i]) == nullptr) {
      kept->keep(keys[i], measured(setting, measurement));
      progress.advance();
    }
    rows.push_back({{"number", i + 1}, {"name", setting.name}});
    rows.back().update(parameters_of(setting));
    rows.back().update(*kept->find(keys[i]));
  }
  return rows;
}

double number_in(const ordered_json& row, const char* key) { return row[key].get<double>(); }

// Whether no other setting is at least as good in ratio and PSNR and better in one.
void mark_front(std::vector<ordered_json>* rows) {
  for (ordered_json& row : *rows) {
    const double ratio = number_in(row, "ratio"), psnr_db = number_in(row, "psnr_db");
    row["on_front"] = std::ranges::none_of(*rows, [&](const ordered_json& other) {
      const double faster = ratio - number_in(other, "ratio");
      const double better = number_in(other, "psnr_db") - psnr_db;
      return faster >= 0.0 && better >= 0.0 && (faster > 0.0 || better > 0.0);
    });
  }
}

double median_of(const std::vector<ordered_json>& rows, const char* key) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const ordered_json& row : rows) values.push_back(number_in(row, key));
  return median(values);
}

TradeSetting setting_of(const NamedOptions& preset, const TradeInput& input) {
  TradeSetting setting{"preset " + preset.name, preset.options, thread_count()};
  setting.options.width = input.views.front().image.cols;
  return setting;
}

// Of trade.json.
ordered_json document_of(const TradeInput& input, const std::vector<ordered_json>& rows) {
  ordered_json json{{"format", "raywalk-trade"},
                    {"format_version", kTradeFormatVersion},
                    {"written_by", "raywalk " RAYWALK_VERSION},
                    {"room", input.room->directory().string()},
                    {"stored_width_px", input.room->panorama().width},
                    {"distances", input.room->distances_origin()},
                    {"distances_sha256", distances_sha256(*input.room)},
                    {"truth", input.truth},
                    {"machine", {{"threads", thread_count()}, {"cpu", cpu_name()}}},
                    {"width_px", input.views.front().image.cols},
                    {"remap_ms", median_of(rows, "remap_ms")},
                    {"repetitions", input.repetitions},
                    {"busy", median_of(rows, "remap_spread") > kBusySpread},
                    {"views", ordered_json::array()},
                    {"parameters", ordered_json::array()},
                    {"presets", ordered_json::array()},
                    {"settings", rows}};
  for (const TrueView& view : input.views) json["views"].push_back(view.name);
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    json["parameters"].push_back({{"key", dial.key},
                                  {"help", dial.help},
                                  {"values", values_text(dial)},
                                  {"default", text_of(dial, default_of(dial))},
                                  {"cost", dial.cost}});
  }
  for (const NamedOptions& preset : input.presets) {
    json["presets"].push_back(
        {{"name", preset.name},
         {"number", find_setting(input.settings, setting_of(preset, input)) + 1},
         {"reason", preset.reason}});
  }
  return json;
}

std::string csv_field(const ordered_json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (!value.is_string()) return value.dump();
  std::string quoted = "\"";
  for (const char c : value.get<std::string>()) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

// The settings, one row each.
std::string csv_of(const std::vector<ordered_json>& rows) {
  std::string header, text;
  for (const auto& [key, value] : rows.front().items()) header += (header.empty() ? "" : ",") + key;
  for (const ordered_json& row : rows) {
    std::string line;
    for (const ordered_json& value : row) line += (line.empty() ? "" : ",") + csv_field(value);
    text += line + "\n";
  }
  return header + "\n" + text;
}

// What settings are chosen by: those on all threads.
MeasuredSettings chosen_by(const TradeInput& input, const std::vector<ordered_json>& rows) {
  MeasuredSettings measured{.distances_sha256 = distances_sha256(*input.room),
                            .width_px = input.views.front().image.cols};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TradeSetting& setting = input.settings[i];
    if (setting.threads != thread_count()) continue;
    measured.choices.push_back({.name = setting.name,
                                .options = setting.options,
                                .ratio = number_in(rows[i], "ratio"),
                                .psnr_db = number_in(rows[i], "psnr_db")});
  }
  return measured;
}

std::string trade_summary(const ordered_json& trade, const fs::path& report) {
  std::string text = fmt::format("{:>8}  {:>7}  {:>8}  {:>6}  {}\n", "ms", "x remap", "PSNR dB",
                                 "SSIM", "settings on the Pareto front");
  const auto add = [&](const ordered_json& row, const std::string& name) {
    text += fmt::format("{:8.2f}  {:7.2f}  {:8.2f}  {:6.4f}  {}\n", number_in(row, "ms"),
                        number_in(row, "ratio"), number_in(row, "psnr_db"), number_in(row, "ssim"),
                        name);
  };
  auto by_time = trade["settings"].get<std::vector<ordered_json>>();
  std::ranges::stable_sort(by_time, {},
                           [](const ordered_json& row) { return number_in(row, "ratio"); });
  for (const ordered_json& row : by_time) {
    if (row["on_front"].get<bool>()) add(row, row["name"].get<std::string>());
  }
  for (const ordered_json& preset : trade["presets"]) {
    add(trade["settings"][preset["number"].get<std::size_t>() - 1],
        "preset " + preset["name"].get<std::string>());
  }
  if (trade["busy"].get<bool>()) {
    text += "other programs were busy meanwhile, so that times are less certain\n";
  }
  const std::string room = escaped(trade["room"].get<std::string>());
  const std::string distances = trade["distances"].get<std::string>();
  text += distances != "none"
              ? fmt::format("{}: distances in use: {}\n", room, distances)
              : room +
                    ": no distances, so only initial views were measured; estimate distances "
                    "with raywalk-build-lf depth\n";
  return text + escaped((report / "index.html").string());
}

// Before minutes of work.
void prepare_report(const fs::path& report, const fs::path& room) {
  make_directories(report);
  const AtomicFile room_probe(measured_settings_path(room));
  for (const char* name : {"trade.json", "trade.csv", "index.html"}) {
    const AtomicFile probe(report / name);
  }
}

// Some truths, spread over the distance from the lines. Throws Error unless all have one width.
std::vector<TrueView> listed_views(const fs::path& list, const Room& room) {
  const std::vector<ListedTruth> truths = read_truth(list, room);
  for (const ListedTruth& truth : truths) {
    if (truth.width == truths.front().width) continue;
    throw Error(fmt::format(
        "{} is {} pixels wide and {} is {}; give truths of one width, as the time of a view "
        "depends on it",
        truth.file.string(), truth.width, truths.front().file.string(), truths.front().width));
  }
  std::vector<TrueView> views;
  for (const std::size_t i : spread_over_distance(truths, kViews)) {
    views.push_back(read_view(truths[i]));
  }
  return views;
}

}  // namespace

std::string trade(const Room& room, const TradeOptions& options) {
  if (options.truth.empty() == (options.held_out == 0)) {
    throw UsageError(
        "give true views with --truth, or use stations as true views with --held-out (one of "
        "both)");
  }
  TradeInput input{.room = &room,
                   .rendered_from = &room,
                   .presets = options.presets,
                   .repetitions = options.repetitions};
  HeldOutViews held_out;
  if (options.held_out > 0) {
    prepare_report(options.report, room.directory());
    held_out = held_out_views(room, options.held_out, kViews);
    input.rendered_from = &held_out.room;
    input.truth = fmt::format("one of {} stations, held out", options.held_out);
    input.views = held_out.views;
  } else {
    input.truth = options.truth.string();
    input.views = listed_views(options.truth, room);
  }
  input.settings = trade_sweep({.centres = options.centres,
                                .width_px = input.views.front().image.cols,
                                .threads = thread_count()});
  // Presets that are not in the sweep are added to it.
  for (const NamedOptions& preset : options.presets) {
    const TradeSetting setting = setting_of(preset, input);
    if (find_setting(input.settings, setting) == input.settings.size()) {
      input.settings.push_back(setting);
    }
  }
  return write_trade(input, options.report);
}

std::string write_trade(const TradeInput& input, const fs::path& report) {
  prepare_report(report, input.room->directory());
  KeptResults kept(report / "trade.partial");
  try {
    std::vector<ordered_json> rows = measured_rows(input, &kept);
    mark_front(&rows);
    const ordered_json document = document_of(input, rows);
    write_file_atomically(report / "trade.json", json_text(document));
    write_measured_settings(input.room->directory(), chosen_by(input, rows));
    write_file_atomically(report / "trade.csv", csv_of(rows));
    write_file_atomically(report / "index.html", report_page("trade", document));
    kept.remove();
    return trade_summary(document, report);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining settings");
  }
}

}  // namespace raywalk
