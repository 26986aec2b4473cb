#include "core/evaluate/trade.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/evaluate/held_out.h"
#include "core/evaluate/kept_results.h"
#include "core/evaluate/trade_settings.h"
#include "core/evaluate/truth_views.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"
#include "core/panorama/pitch_remap.h"
#include "core/report/report.h"
#include "core/room/requirements.h"
#include "core/room/room.h"
#include "core/view/renderer.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kTradeFormatVersion = 7;
constexpr std::size_t kViews = 6;
// The remap does the same work every time: where its upper quartile is above its least time by more
// than this part, other programs were busy, and times are less certain.
constexpr double kBusySpread = 0.25;

struct Trade {
  const Room& room;
  const TradeOptions& options;
  HeldOutViews truth{};  // its room: the same, or without stations that were held out
  int width_px = 0;      // of the views
  std::vector<TradeSetting> settings{};
  std::string card{};                            // that settings are measured on too; empty: none
  ordered_json presets = ordered_json::array();  // of trade.json
};

// Some truths, spread over the distance from the lines. Throws Error unless all have one width.
std::vector<TrueView> listed_views(const TradeOptions& options, const Room& room) {
  const std::vector<ListedTruth> truths = read_truth(options.truth, room);
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
    views.back().own_exposure = options.match_exposure;
  }
  return views;
}

// Before minutes of work.
void prepare_report(const fs::path& report, const fs::path& room) {
  make_directories(report);
  const AtomicFile room_probe(measured_settings_path(room));
  for (const char* name : {"trade.json", "trade.csv", "index.html"}) {
    const AtomicFile probe(report / name);
  }
}

Trade prepared(const Room& room, const TradeOptions& options) {
  Trade trade{.room = room, .options = options};
  if (options.held_out == 0) trade.truth = {room, listed_views(options, room)};
  prepare_report(options.report, room.directory());
  if (options.held_out > 0) trade.truth = held_out_views(room, options.held_out, kViews);
  trade.width_px = trade.truth.views.front().image.cols;
  trade.settings = trade_sweep(options.centres, trade.width_px, thread_count());
  // Presets that are not in the sweep are added to it.
  for (const NamedOptions& preset : options.presets) {
    TradeSetting setting{"preset " + preset.name, preset.options, thread_count()};
    setting.options.width = trade.width_px;
    trade.presets.push_back({{"name", preset.name},
                             {"number", add_setting(setting, &trade.settings) + 1},
                             {"reason", preset.reason}});
  }
  choose_device(options.device, options.gpu_mb);
  if (on_graphics_card()) {
    trade.card = device_name();
    repeat_on(options.device, thread_count(), &trade.settings);
  }
  return trade;
}

Viewpoint viewpoint_of(const TrueView& view, const TradeSetting& setting) {
  return viewpoint_for(setting.options.method, view.viewpoint, view.height_m);
}

// {"ms", "ratio" to a remap, "remap_ms"}: medians over all runs of all views; and "remap_spread",
// how far the upper quartile of the remap's time is above the least, as a part of it.
ordered_json times_of_views(const TradeSetting& setting, const Trade& trade, Renderer* renderer) {
  const TimeSource& time_source = trade.options.time_source;
  RenderedView shown;
  const auto time_of = [&](const TrueView& view) {
    const Viewpoint at = viewpoint_of(view, setting);
    const int all_threads = thread_count();
    set_thread_count(setting.threads);
    const double taken_s = time_source([&] { shown = renderer->render(at, std::move(shown)); });
    set_thread_count(all_threads);
    return taken_s;
  };
  PitchRemap remap(trade.width_px);
  int runs = 1;
  const auto time_of_remap = [&] {
    const auto all = [&] {
      for (int run = 0; run < runs; ++run) remap.run();
    };
    return time_source(all) / runs;
  };
  for (const TrueView& view : trade.truth.views) time_of(view);
  // As often as it takes to last a while: waking the threads would make the time of a single remap
  // of a small image uneven.
  constexpr double kLeast_s = 2e-3;
  constexpr int kMostRuns = 100;
  remap.run();
  runs = std::clamp(static_cast<int>(std::ceil(kLeast_s / time_of_remap())), 1, kMostRuns);
  std::vector<double> view_s, remap_s, ratios;
  for (int i = 0; i < trade.options.repetitions; ++i) {
    for (const TrueView& view : trade.truth.views) {
      throw_if_interrupted();
      if (setting.threads != thread_count()) remap.run();  // wakes the other threads again
      remap_s.push_back(time_of_remap());
      view_s.push_back(time_of(view));
      ratios.push_back(view_s.back() / remap_s.back());
    }
  }
  std::ranges::sort(remap_s);
  return {{"ms", 1e3 * median(view_s)},
          {"ratio", median(ratios)},
          {"remap_ms", 1e3 * median(remap_s)},
          {"remap_spread", remap_s[remap_s.size() * 3 / 4] / remap_s.front() - 1.0}};
}

// The times, and the means of the scores.
ordered_json measured(const TradeSetting& setting, const Trade& trade) {
  choose_device(setting.device, trade.options.gpu_mb);
  Renderer renderer(trade.truth.room, setting.options);
  choose_device(Device::kCpu);
  ordered_json result = times_of_views(setting, trade, &renderer);
  const std::vector<TrueView>& truths = trade.truth.views;
  std::vector<cv::Mat> images(truths.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    throw_if_interrupted();
    const cv::Mat image = renderer.render(viewpoint_of(truths[i], setting)).image;
    cv::resize(image, images[i], truths[i].image.size(), 0, 0, cv::INTER_LINEAR);
  }
  std::vector<ordered_json> scores(images.size());
  parallel_for(0, static_cast<int>(images.size()), 1, [&](int begin, int /*end*/) {
    const auto i = static_cast<std::size_t>(begin);
    const cv::Mat view = exposed_as(truths[i], images[i]);
    scores[i] = scores_of(view, truths[i], features_of(view, truths[i]));
  });
  for (const auto& [key, value] : scores.front().items()) result[key] = mean_of(scores, key);
  return result;
}

// The name of this machine's processor.
std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

// Everything that measurements depend on, except the settings.
std::string fingerprint_of(const Trade& trade) {
  std::string text =
      fmt::format("trade {} {} {} {} {}\n", trade.options.repetitions, thread_count(), cpu_name(),
                  trade.card, room_fingerprint(trade.room));
  for (const TrueView& view : trade.truth.views) {
    text += fmt::format("{} {} {} {} {} {} {}\n", view.name, view.viewpoint.x_m,
                        view.height_m.value_or(0.0), view.viewpoint.z_m, view.own_exposure,
                        sha256_of_pixels(view.image), sha256_of_pixels(view.mask));
  }
  return text;
}

double number_in(const ordered_json& row, const char* key) { return row[key].get<double>(); }

// Of trade.json: each setting's parameters and what was measured of it. What an earlier run
// measured is not measured again. On the front: no other setting is at least as good in ratio and
// PSNR and better in one.
std::vector<ordered_json> measured_rows(const Trade& trade, KeptResults* kept) {
  const std::string fingerprint = fingerprint_of(trade);
  std::vector<std::string> keys;
  keys.reserve(trade.settings.size());
  for (const TradeSetting& setting : trade.settings) {
    keys.push_back(sha256_hex(fingerprint + parameters_of(setting).dump()));
  }
  std::vector<ordered_json> rows = kept->get_all(
      keys, "trade", "settings", [&](std::size_t i) { return measured(trade.settings[i], trade); });
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TradeSetting& setting = trade.settings[i];
    ordered_json row{{"number", i + 1}, {"name", setting.name}};
    row.update(parameters_of(setting));
    row.update(rows[i]);
    rows[i] = std::move(row);
  }
  for (ordered_json& row : rows) {
    row["on_front"] = std::ranges::none_of(rows, [&](const ordered_json& other) {
      const double faster = number_in(row, "ratio") - number_in(other, "ratio");
      const double better = number_in(other, "psnr_db") - number_in(row, "psnr_db");
      return faster >= 0.0 && better >= 0.0 && (faster > 0.0 || better > 0.0);
    });
  }
  return rows;
}

double median_of(const std::vector<ordered_json>& rows, const char* key) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const ordered_json& row : rows) values.push_back(number_in(row, key));
  return median(std::move(values));
}

// Of trade.json.
ordered_json document_of(const Trade& trade, const std::vector<ordered_json>& rows) {
  const TradeOptions& options = trade.options;
  ordered_json views = ordered_json::array(), parameters = ordered_json::array();
  for (const TrueView& view : trade.truth.views) views.push_back(view.name);
  for (const ViewParameter& parameter : kViewParameters) {
    if (!parameter.sweep) continue;
    parameters.push_back({{"key", parameter.key},
                          {"help", parameter.help},
                          {"values", values_text(parameter)},
                          {"default", text_of(parameter, default_of(parameter))},
                          {"cost", parameter.cost}});
  }
  return {
      {"format", "raywalk-trade"},
      {"format_version", kTradeFormatVersion},
      {"written_by", "raywalk " RAYWALK_VERSION},
      {"room", trade.room.directory().string()},
      {"stored_width_px", trade.room.panorama().width},
      {"distances", trade.room.distances_origin()},
      {"distances_sha256", distances_sha256(trade.room)},
      {"truth", options.held_out > 0 ? fmt::format("one of {} stations, held out", options.held_out)
                                     : options.truth.string()},
      {"machine", {{"threads", thread_count()}, {"cpu", cpu_name()}, {"gpu", trade.card}}},
      {"width_px", trade.width_px},
      {"remap_ms", median_of(rows, "remap_ms")},
      {"repetitions", options.repetitions},
      {"busy", median_of(rows, "remap_spread") > kBusySpread},
      {"views", std::move(views)},
      {"parameters", std::move(parameters)},
      {"presets", trade.presets},
      {"settings", rows}};
}

std::string field_of(const ordered_json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return value.is_string() ? csv_field(value.get<std::string>()) : value.dump();
}

// The settings, one row each.
std::string csv_of(const std::vector<ordered_json>& rows) {
  std::vector<std::string> fields;
  for (const auto& [key, value] : rows.front().items()) fields.push_back(key);
  std::string text = fmt::format("{}\n", fmt::join(fields, ","));
  for (const ordered_json& row : rows) {
    fields.clear();
    for (const ordered_json& value : row) fields.push_back(field_of(value));
    text += fmt::format("{}\n", fmt::join(fields, ","));
  }
  return text;
}

// What settings are chosen by: those of the processor on all threads.
MeasuredSettings chosen_by(const Trade& trade, const std::vector<ordered_json>& rows) {
  MeasuredSettings measured{.distances_sha256 = distances_sha256(trade.room),
                            .width_px = trade.width_px};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TradeSetting& setting = trade.settings[i];
    if (setting.threads != thread_count() || setting.device != Device::kCpu) continue;
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

}  // namespace

std::string trade(const Room& room, const TradeOptions& options) {
  if (options.truth.empty() == (options.held_out == 0)) {
    throw UsageError(
        "give true views with --truth, or use stations as true views with --held-out (one of "
        "both)");
  }
  const Trade trade = prepared(room, options);
  const fs::path& report = options.report;
  KeptResults kept(report / "trade.partial");
  try {
    const std::vector<ordered_json> rows = measured_rows(trade, &kept);
    const ordered_json document = document_of(trade, rows);
    write_file_atomically(report / "trade.json", json_text(document));
    write_measured_settings(room.directory(), chosen_by(trade, rows));
    write_file_atomically(report / "trade.csv", csv_of(rows));
    write_file_atomically(report / "index.html", report_page("trade", document));
    kept.remove();
    return trade_summary(document, report);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining settings");
  }
}

}  // namespace raywalk
