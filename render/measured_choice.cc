#include "render/measured_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/judge/trade/trade.h"
#include "core/judge/trade/trade_json.h"
#include "core/panorama/pitch_remap.h"
#include "core/room/requirements.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

// One cv::remap on this machine now.
struct RemapTime {
  double ms = 0.0;
  bool disturbed = false;
};

// The text of a choice, which `parse` knows.
template <typename Parse>
std::string choice_from(const CheckedJson& json, const Parse& parse) {
  std::string text = json.text();
  try {
    parse(text);
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
  return text;
}

int width_from(const CheckedJson& json) {
  const int width_px = json.integer(4, kMaxViewWidth_px);
  if (width_px % 4 != 0) json.fail(fmt::format("{} is not a multiple of 4", width_px));
  return width_px;
}

std::string layers_from(const CheckedJson& json) {
  if (!json.is_text()) return std::to_string(json.integer(1, kMaxLayers));
  if (json.text() != "auto") json.fail("is neither auto nor a number");
  return "auto";
}

ViewSettings settings_from(const CheckedJson& parameters) {
  ViewSettings settings;
  settings.generation = choice_from(parameters.at("generation"), generation_from_name);
  settings.k_deg = fmt::format("{}", parameters.at("k_deg").number(kMinK_deg, kMaxK_deg));
  settings.overlap_deg = parameters.at("overlap_deg").number(0.0, kMaxOverlap_deg);
  settings.layers = layers_from(parameters.at("layers"));
  settings.width_px = width_from(parameters.at("width_px"));
  settings.interpolation = choice_from(parameters.at("interpolation"), interpolation_from_name);
  settings.arithmetic = choice_from(parameters.at("arithmetic"), arithmetic_from_name);
  settings.second_side = choice_from(parameters.at("second_side"), second_side_from_name);
  settings.stations_mixed = parameters.at("stations_mixed").integer(1, kMaxStationsMixed);
  settings.station_stride = parameters.at("station_stride").integer(1, kMaxStationStride);
  settings.distance_maps = parameters.at("distance_maps").integer(1, kMaxDistanceMaps);
  settings.fill_stations = parameters.at("fill_stations").integer(0, kMaxFillStations);
  settings.skip_px = parameters.at("skip_px").number(0.0, kMaxSkip_px);
  return settings;
}

MeasuredChoice choice_of(const CheckedJson& setting) {
  constexpr double kMostRatio = 1e9;  // a damaged file is not believed
  return {.name = setting.at("name").text(),
          .settings = settings_from(setting),
          .ratio = setting.at("ratio").number(0.0, kMostRatio),
          .psnr_db = setting.at("psnr_db").number(0.0, kMaxPsnrDb),
          .disturbed = setting.at("disturbed").boolean()};
}

// Five runs after a warm-up run; where other programs disturb them, again, up to three times.
RemapTime time_of_remap(int width_px, const TimeSource& source) {
  constexpr int kRuns = 5;
  constexpr int kTries = 3;
  PitchRemap remap(width_px);
  RemapTime time;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::vector<TimedPair> pairs;
    const ProcessorUse before = source.processor_use();
    for (int run = 0; run <= kRuns; ++run) {
      const Times taken = source.times([&] { remap.run(); });
      if (run > 0) pairs.push_back({taken, taken});
    }
    const ViewTime measured = view_time_of(pairs, share_of_others(before, source.processor_use()));
    time = {measured.remap_ms, disturbance(measured, measured.remap_ms) > 1.0};
    if (!time.disturbed) break;
  }
  return time;
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

// What is said of settings whose times are not to be relied on.
std::string left_out_text(std::size_t count) {
  if (count == 0) return "";
  return fmt::format("; {} settings with disturbed times are left out", count);
}

}  // namespace

MeasuredTrade measured_trade_from_json(const std::string& text, const std::string& source) {
  const CheckedJson root =
      CheckedJson::parse(text, source, "measure again with raywalk-render trade");
  root.require_version(kTradeFormatVersion);
  MeasuredTrade trade{root.at("distances_sha256").text(), width_from(root.at("width_px")), {}};
  const std::vector<CheckedJson> rooms = root.at("rooms").items();
  if (rooms.empty()) root.at("rooms").fail("is empty");
  const std::string depth = rooms.front().at("depth").text();
  const int stored_width_px = rooms.front().at("stored_width_px").integer(1);
  const int threads = root.at("machine").at("threads").integer(1);
  for (const CheckedJson& setting : root.at("settings").items()) {
    if (setting.at("depth").text() != depth || setting.at("threads").integer(1) != threads ||
        setting.at("stored_width_px").integer(1) != stored_width_px) {
      continue;
    }
    trade.choices.push_back(choice_of(setting));
  }
  if (trade.choices.empty()) root.fail("holds no setting of its own room");
  return trade;
}

Preset choose_setting(const MeasuredTrade& trade, const Demand& demand, double remap_ms) {
  std::vector<MeasuredChoice> by_time = trade.choices;
  const auto left_out =
      std::erase_if(by_time, [](const MeasuredChoice& choice) { return choice.disturbed; });
  if (by_time.empty()) {
    throw Error(fmt::format(
        "no setting can be chosen: other programs disturbed the times of all {} that trade "
        "measured on this room; run raywalk-render trade again while nothing else runs",
        left_out));
  }
  std::ranges::stable_sort(by_time, {}, &MeasuredChoice::ratio);
  const auto best = std::ranges::max_element(by_time, {}, &MeasuredChoice::psnr_db);
  if (demand.min_psnr_db && best->psnr_db < *demand.min_psnr_db) {
    throw Error(
        fmt::format("no setting measured on this room reaches {:g} dB; the best, {}, has "
                    "{:.2f} dB at {:.3g} ms{}",
                    *demand.min_psnr_db, best->name, best->psnr_db, best->ratio * remap_ms,
                    left_out_text(left_out)));
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
                    "fastest takes {:.3g} ms ({}){}",
                    *demand.budget_ms,
                    demand.min_psnr_db ? fmt::format(" with {:g} dB", *demand.min_psnr_db) : "",
                    better->ratio * remap_ms, better->name, left_out_text(left_out)));
  }
  return {chosen->settings,
          reason_for(*chosen, better, demand, remap_ms) + left_out_text(left_out)};
}

void require_demand(const Demand& demand) {
  // The command line's own checks let NaN pass.
  constexpr double kMostMs = 1e7;
  if (demand.budget_ms && !(*demand.budget_ms > 0.0 && *demand.budget_ms <= kMostMs)) {
    throw UsageError(fmt::format("--budget-ms is {:g}; give milliseconds above 0, at most {:g}",
                                 *demand.budget_ms, kMostMs));
  }
  if (demand.min_psnr_db && !(*demand.min_psnr_db >= 0.0 && *demand.min_psnr_db <= kMaxPsnrDb)) {
    throw UsageError(fmt::format("--min-psnr-db is {:g}; give decibels from 0 to {:g}",
                                 *demand.min_psnr_db, kMaxPsnrDb));
  }
}

Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room,
                         const TimeSource& source) {
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
  const RemapTime remap = time_of_remap(trade.width_px, source);
  Preset chosen = choose_setting(trade, demand, remap.ms);
  if (remap.disturbed) {
    chosen.reason += "; other programs use this machine now, so that views may take longer";
  }
  const std::string measured_k_deg = chosen.settings.k_deg;
  chosen.settings = view_settings(flags, chosen.settings);
  if (!flags.k_deg && chosen.settings.k_deg == measured_k_deg) {
    chosen.k_source = "of the setting that trade measured";
  }
  return chosen;
}

}  // namespace raywalk::render
