#include "render/measured_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/panorama/pitch_remap.h"
#include "core/room/requirements.h"
#include "render/trade/trade.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

ViewSettings settings_from(const CheckedJson& parameters) {
  const CheckedJson layers = parameters.at("layers");
  ViewSettings settings;
  settings.generation = parameters.at("generation").text();
  settings.k_deg = fmt::format("{}", parameters.at("k_deg").number());
  settings.overlap_deg = parameters.at("overlap_deg").number();
  settings.layers = layers.is_text() ? layers.text() : std::to_string(layers.integer());
  settings.width_px = parameters.at("width_px").integer();
  settings.interpolation = parameters.at("interpolation").text();
  settings.arithmetic = parameters.at("arithmetic").text();
  settings.second_side = parameters.at("second_side").text();
  settings.stations_mixed = parameters.at("stations_mixed").integer();
  settings.station_stride = parameters.at("station_stride").integer();
  settings.distance_maps = parameters.at("distance_maps").integer();
  settings.fill_stations = parameters.at("fill_stations").integer();
  settings.skip_px = parameters.at("skip_px").number();
  return settings;
}

// Median of five runs after a warm-up run.
double time_of_remap_ms(int width_px) {
  PitchRemap remap(width_px);
  std::vector<double> times_ms;
  for (int run = 0; run < 6; ++run) {
    const double taken_s = times_of([&] { remap.run(); }).wall_s;
    if (run > 0) times_ms.push_back(1e3 * taken_s);
  }
  return median(std::move(times_ms));
}

std::string reason_for(const MeasuredChoice& chosen, const MeasuredChoice* better,
                       const Demand& demand, double remap_ms) {
  std::string reason = fmt::format(
      "{}: {:.2f} dB at {:.3g} ms as measured by trade on this room ({:.2g} times "
      "cv::remap, which takes {:.3g} ms here)",
      chosen.name, chosen.psnr_db, chosen.ratio * remap_ms, chosen.ratio, remap_ms);
  if (demand.min_psnr_db) {
    return reason + fmt::format(": the fastest with at least {:g} dB", *demand.min_psnr_db);
  }
  reason += fmt::format(": the best within {:g} ms", *demand.budget_ms);
  if (better != nullptr) {
    reason += fmt::format("; {:.2f} dB would take {:.3g} ms ({})", better->psnr_db,
                          better->ratio * remap_ms, better->name);
  }
  return reason;
}

}  // namespace

MeasuredTrade measured_trade_from_json(const std::string& text, const std::string& source) {
  const CheckedJson root =
      CheckedJson::parse(text, source, "measure again with raywalk-render trade");
  root.require_version(1);
  MeasuredTrade trade{root.at("distances_sha256").text(), root.at("width_px").integer(), {}};
  const std::vector<CheckedJson> rooms = root.at("rooms").items();
  if (rooms.empty()) root.at("rooms").fail("is empty");
  const std::string depth = rooms.front().at("depth").text();
  const int stored_width_px = rooms.front().at("stored_width_px").integer();
  const int threads = root.at("machine").at("threads").integer();
  for (const CheckedJson& setting : root.at("settings").items()) {
    if (setting.at("depth").text() != depth || setting.at("threads").integer() != threads ||
        setting.at("stored_width_px").integer() != stored_width_px) {
      continue;
    }
    trade.choices.push_back({setting.at("name").text(), settings_from(setting),
                             setting.at("ratio").number(), setting.at("psnr_db").number()});
  }
  if (trade.choices.empty()) root.fail("holds no setting of its own room");
  return trade;
}

Preset choose_setting(const MeasuredTrade& trade, const Demand& demand, double remap_ms) {
  std::vector<MeasuredChoice> by_time = trade.choices;
  std::ranges::stable_sort(by_time, {}, &MeasuredChoice::ratio);
  const auto best = std::ranges::max_element(by_time, {}, &MeasuredChoice::psnr_db);
  if (demand.min_psnr_db && best->psnr_db < *demand.min_psnr_db) {
    throw Error(
        fmt::format("no setting measured on this room reaches {:g} dB; the best, {}, has "
                    "{:.2f} dB at {:.3g} ms",
                    *demand.min_psnr_db, best->name, best->psnr_db, best->ratio * remap_ms));
  }
  const auto enough = [&](const MeasuredChoice& choice) {
    return !demand.min_psnr_db || choice.psnr_db >= *demand.min_psnr_db;
  };
  const auto in_time = [&](const MeasuredChoice& choice) {
    return !demand.budget_ms || choice.ratio * remap_ms <= *demand.budget_ms;
  };
  // Fastest first: the first that meets the minimum PSNR, else the most accurate within the budget.
  const MeasuredChoice* chosen = nullptr;
  const MeasuredChoice* better = nullptr;
  for (const MeasuredChoice& choice : by_time) {
    if (!enough(choice)) continue;
    const bool improves =
        chosen == nullptr || (!demand.min_psnr_db && choice.psnr_db > chosen->psnr_db);
    if (!improves) continue;
    if (in_time(choice)) {
      chosen = &choice;
    } else if (better == nullptr) {
      better = &choice;
    }
  }
  if (chosen == nullptr) {
    throw Error(
        fmt::format("no setting measured on this room meets a budget of {:g} ms{}; the "
                    "fastest takes {:.3g} ms ({})",
                    *demand.budget_ms,
                    demand.min_psnr_db ? fmt::format(" with {:g} dB", *demand.min_psnr_db) : "",
                    better->ratio * remap_ms, better->name));
  }
  return {chosen->settings, reason_for(*chosen, better, demand, remap_ms)};
}

Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room) {
  const fs::path file = trade_path(room.directory());
  std::error_code error;
  if (!fs::exists(file, error)) {
    throw Error(
        fmt::format("{}: no trade was measured on this room; run raywalk-render trade on it first",
                    room.directory().string()));
  }
  const MeasuredTrade trade = measured_trade_from_json(read_file(file), file.string());
  if (trade.distances_sha256 != distances_sha256(room)) {
    throw Error(
        file.string() +
        ": was measured with other distances than the room has now; run raywalk-render trade "
        "again");
  }
  Preset chosen = choose_setting(trade, demand, time_of_remap_ms(trade.width_px));
  chosen.settings = view_settings(flags, chosen.settings);
  return chosen;
}

}  // namespace raywalk::render
