#include "render/view/measured_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/panorama/pitch_remap.h"
#include "core/room/requirements.h"

namespace raywalk::render {
namespace {

// Of one cv::remap on this machine now, ms: the median of five runs after a warm-up run.
double time_of_remap_ms(int width_px, const TimeSource& source) {
  constexpr int kRuns = 5;
  PitchRemap remap(width_px);
  std::vector<double> times_s;
  for (int run = 0; run <= kRuns; ++run) {
    const double taken_s = source([&] { remap.run(); });
    if (run > 0) times_s.push_back(taken_s);
  }
  return 1e3 * median(times_s);
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

Preset choose_setting(const MeasuredSettings& measured, const Demand& demand, double remap_ms) {
  std::vector<MeasuredChoice> by_time = measured.choices;
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
  return {{.options = chosen->options}, reason_for(*chosen, better, demand, remap_ms)};
}

void require_demand(const Demand& demand) {
  // The command line's own checks let NaN pass.
  constexpr double kMostMs = 1e7;
  if (demand.budget_ms && !(*demand.budget_ms > 0.0 && *demand.budget_ms <= kMostMs)) {
    throw UsageError(fmt::format("--budget-ms is {:g}; give milliseconds above 0, at most {:g}",
                                 *demand.budget_ms, kMostMs));
  }
  if (demand.min_psnr_db && !(*demand.min_psnr_db >= 0.0 && *demand.min_psnr_db <= kMostPsnr_db)) {
    throw UsageError(fmt::format("--min-psnr-db is {:g}; give decibels from 0 to {:g}",
                                 *demand.min_psnr_db, kMostPsnr_db));
  }
}

Preset demanded_settings(const ViewFlags& flags, const Demand& demand, const Room& room,
                         const TimeSource& source) {
  const std::optional<MeasuredSettings> measured = read_measured_settings(room.directory());
  if (!measured) {
    throw Error(
        fmt::format("{}: no trade was measured on this room; run raywalk-render trade on it first",
                    room.directory().string()));
  }
  if (measured->distances_sha256 != distances_sha256(room)) {
    throw Error(
        measured_settings_path(room.directory()).string() +
        ": was measured with other distances than the room has now; run raywalk-render trade "
        "again");
  }
  Preset chosen = choose_setting(*measured, demand, time_of_remap_ms(measured->width_px, source));
  const double measured_k_deg = chosen.settings.options.k_deg;
  chosen.settings = view_settings(flags, chosen.settings);
  if (!flags.parameters.contains("k_deg") && chosen.settings.options.k_deg == measured_k_deg) {
    chosen.k_source = "of the setting that trade measured";
  }
  return chosen;
}

Preset settings_for(const ViewFlags& flags, const Demand& demand, const Room& room) {
  const bool demanded = demand.budget_ms || demand.min_psnr_db;
  return demanded ? demanded_settings(flags, demand, room) : preset_settings(flags, room);
}

ViewMode mode_of(const Preset& chosen) {
  ViewMode mode = view_mode(chosen.settings);
  if (!chosen.k_source.empty()) mode.k_source = chosen.k_source;
  return mode;
}

}  // namespace raywalk::render
