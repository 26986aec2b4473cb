#include "build_lf/exposure/room_gains.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/gain_significance.h"
#include "build_lf/exposure/gain_solver.h"
#include "build_lf/exposure/station_ratios.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

// Log gains of whole pictures: a row for each station, a column for each channel.
using WholeGains = Eigen::MatrixX3d;

WholeGains solve_whole_gains(const std::vector<WholeRatio>& ratios, int stations) {
  WholeGains whole(stations, 3);
  for (int c = 0; c < 3; ++c) {
    std::vector<GainEquation> equations;
    for (const WholeRatio& ratio : ratios) {
      if (ratio.known) equations.push_back(ratio.channels[static_cast<size_t>(c)]);
    }
    whole.col(c) = solve_gain_graph(equations, stations);
  }
  return whole;
}

// What is measured between the stations of a window, which are numbered by their place in it.
struct WindowRatios {
  WholeGains whole;                                  // of the stations
  std::vector<PatchRatio> patches;                   // less those of the whole pictures' gains
  std::vector<std::array<bool, kPatches>> measured;  // [station][patch]: whether it has a ratio
};

WindowRatios ratios_within(const GainWindow& window, const StationRatios& all,
                           const WholeGains& whole) {
  WindowRatios within{whole(window.stations, Eigen::all), {}, {}};
  within.measured.resize(window.stations.size());
  const auto place_of = [&](int station) {
    const auto found = std::ranges::lower_bound(window.stations, station);
    const bool is_in = found != window.stations.end() && *found == station;
    return is_in ? static_cast<int>(found - window.stations.begin()) : -1;
  };
  int last_group = -1;
  for (const int station : window.stations) {
    const int group = station / kRatioGroup;
    if (group == last_group) continue;
    last_group = group;
    for (PatchRatio ratio : all.patches[static_cast<size_t>(group)]) {
      const int from = place_of(ratio.from / kPatches);
      const int to = place_of(ratio.to / kPatches);
      if (from < 0 || to < 0) continue;
      const int patch_from = ratio.from % kPatches;
      const int patch_to = ratio.to % kPatches;
      within.measured[static_cast<size_t>(from)][static_cast<size_t>(patch_from)] = true;
      within.measured[static_cast<size_t>(to)][static_cast<size_t>(patch_to)] = true;
      ratio.from = from * kPatches + patch_from;
      ratio.to = to * kPatches + patch_to;
      for (int c = 0; c < 3; ++c) {
        const double of_whole = within.whole(from, c) - within.whole(to, c);
        ratio.log_ratio[static_cast<size_t>(c)] -= static_cast<float>(of_whole);
      }
      within.patches.push_back(ratio);
    }
  }
  return within;
}

// Log gains of a window's patches: for each channel a column per station.
using WindowGains = std::array<Eigen::MatrixXd, 3>;

// Solves for parts of the ratios, from a guess.
std::vector<WindowGains> solve_parts(const WindowRatios& ratios, std::span<const Part> parts,
                                     const WindowGains& guess) {
  std::vector<WindowGains> solved(parts.size());
  const auto stations = static_cast<int>(ratios.whole.rows());
  parallel_for(0, 3 * static_cast<int>(parts.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const size_t c = i % 3;
      solved[i / 3][c] = solve_patch_gains(ratios.patches, parts[i / 3], c, stations, guess[c]);
    }
  });
  return solved;
}

// Of a station of the window: without spots, and with the whole picture's gain.
PatchGains station_gains(const WindowGains& solved, const WindowRatios& ratios, int station) {
  PatchGains gains;
  for (int c = 0; c < 3; ++c) {
    gains.col(c) = without_spots(solved[static_cast<size_t>(c)].col(station)).array() +
                   ratios.whole(station, c);
  }
  return gains;
}

GainField field_of(const KeptGains& kept) {
  const auto factors = [](const auto& log_gains) {
    cv::Vec3f gain;
    for (int c = 0; c < 3; ++c) gain[c] = static_cast<float>(std::exp(log_gains[c]));
    return gain;
  };
  GainField field{.whole = factors(kept.whole)};
  if (!kept.patches) return field;
  field.local.create(kPatchesTheta, kPatchesPhi, CV_32FC3);
  for (int patch = 0; patch < kPatches; ++patch) {
    field.local.at<cv::Vec3f>(patch / kPatchesPhi, patch % kPatchesPhi) =
        factors(kept.patches->row(patch));
  }
  return field;
}

// Solves for the gains of a window's stations and sets those of `fields` that it keeps.
void solve_window(const GainWindow& window, std::span<const StationIndex> stations,
                  const StationRatios& all, const WholeGains& whole, GainFields* fields) {
  const WindowRatios ratios = ratios_within(window, all, whole);
  const WindowGains solved = solve_parts(ratios, std::array{Part::kAll}, {}).front();
  std::vector<PatchGains> gains;
  gains.reserve(window.stations.size());
  bool significant = false;  // whether any would be kept if the halves agreed
  for (size_t i = 0; i < window.stations.size(); ++i) {
    const PatchGains& own = gains.emplace_back(station_gains(solved, ratios, static_cast<int>(i)));
    const KeptGains most = keep_significant(own, {own, own}, ratios.measured[i]);
    significant = significant || most.patches || !most.whole.isZero(0.0);
  }
  if (!significant) return;  // the halves take twice as long to solve for
  const std::vector<WindowGains> halves =
      solve_parts(ratios, std::array{Part::kBlack, Part::kWhite}, solved);
  for (size_t i = 0; i < window.stations.size(); ++i) {
    if (!window.kept[i]) continue;
    const auto place = static_cast<int>(i);
    const auto [line, station] = stations[static_cast<size_t>(window.stations[i])];
    (*fields)[static_cast<size_t>(line)][static_cast<size_t>(station)] = field_of(keep_significant(
        gains[i],
        {station_gains(halves[0], ratios, place), station_gains(halves[1], ratios, place)},
        ratios.measured[i]));
  }
}

}  // namespace

GainFields solve_room_gains(const Room& room, const SurfaceMaps& maps, int most_at_once) {
  const std::vector<StationIndex> stations = all_stations(room.grid());
  StationRatios ratios(room.directory());
  measure_ratios(room, maps, &ratios);
  const WholeGains whole = solve_whole_gains(ratios.whole, static_cast<int>(stations.size()));
  std::vector<Eigen::Vector3d> positions_m;
  positions_m.reserve(stations.size());
  for (const StationIndex s : stations) positions_m.push_back(room.grid().station(s).position_m);
  GainFields fields = unit_gain_fields(room.grid());
  const std::vector<GainWindow> windows = gain_windows(positions_m, ratios.whole, most_at_once);
  Progress progress("solving for gains", static_cast<std::int64_t>(windows.size()), "windows");
  for (const GainWindow& window : windows) {
    throw_if_interrupted();
    solve_window(window, stations, ratios, whole, &fields);
    progress.advance();
  }
  return fields;
}

}  // namespace raywalk::build_lf
