#include "build_lf/exposure/room_gains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/gain_significance.h"
#include "build_lf/exposure/gain_solver.h"
#include "build_lf/exposure/station_ratios.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

Eigen::Vector3d position_of(const Grid& grid, StationIndex station) {
  const Line& line = grid.lines[static_cast<size_t>(station.line)];
  return line.stations[static_cast<size_t>(station.station)].position_m;
}

// The log gains of whole pictures in one channel.
std::vector<double> whole_gains(const std::vector<WholeRatio>& ratios, size_t channel,
                                int stations) {
  std::vector<GainEquation> equations;
  for (const WholeRatio& ratio : ratios) {
    if (ratio.known) equations.push_back(ratio.channels[channel]);
  }
  const Eigen::VectorXd solved = solve_gain_graph(equations, stations);
  return {solved.data(), solved.data() + solved.size()};
}

// Log gains of whole pictures, [channel][station].
using WholeGains = std::array<std::vector<double>, 3>;

// The equations of a window's patches: the ratios less those of the whole pictures' gains, which
// are those of the window's stations.
std::vector<PatchEquation> equations_of(const std::vector<StationRatios>& all,
                                        const WholeGains& whole) {
  std::vector<PatchEquation> equations;
  for (const StationRatios& ratios : all) {
    for (const PatchRatio& patch : ratios.patches) {
      PatchEquation& equation = equations.emplace_back();
      equation.from = ratios.from * kPatches + patch.from;
      equation.to = ratios.to * kPatches + patch.to;
      equation.error = patch.error;
      for (size_t c = 0; c < 3; ++c) {
        const double of_whole =
            whole[c][static_cast<size_t>(ratios.from)] - whole[c][static_cast<size_t>(ratios.to)];
        equation.difference[c] = patch.log_ratio[c] - static_cast<float>(of_whole);
      }
    }
  }
  return equations;
}

// The ratios between stations of a window, which are numbered by their place in it.
std::vector<StationRatios> ratios_within(const GainWindow& window, const RatioFile& file) {
  std::vector<StationRatios> within;
  for (size_t to = 0; to < window.stations.size(); ++to) {
    for (StationRatios& ratios : file.get(window.stations[to])) {
      const auto from = std::ranges::lower_bound(window.stations, ratios.from);
      if (from == window.stations.end() || *from != ratios.from) continue;
      ratios.from = static_cast<int>(from - window.stations.begin());
      ratios.to = static_cast<int>(to);
      within.push_back(std::move(ratios));
    }
  }
  return within;
}

WholeGains whole_within(const GainWindow& window, const WholeGains& whole) {
  WholeGains within;
  for (size_t c = 0; c < 3; ++c) {
    for (const int station : window.stations) {
      within[c].push_back(whole[c][static_cast<size_t>(station)]);
    }
  }
  return within;
}

// Log gains of all patches, [channel][station * kPatches + patch].
using RoomPatches = std::array<std::vector<double>, 3>;

// Without spots, and with the whole pictures' gains.
std::vector<double> finished(const std::vector<double>& solved, const std::vector<double>& whole) {
  std::vector<double> patches;
  patches.reserve(solved.size());
  for (size_t s = 0; s < whole.size(); ++s) {
    for (const double gain : without_spots(std::span(solved).subspan(s * kPatches, kPatches))) {
      patches.push_back(whole[s] + gain);
    }
  }
  return patches;
}

// Solves the given parts of the equations, from a guess.
std::vector<RoomPatches> solve_parts(std::span<const PatchEquation> equations,
                                     std::span<const Part> parts, const WholeGains& whole,
                                     const RoomPatches& guess) {
  std::vector<RoomPatches> solved(parts.size());
  const auto stations = static_cast<int>(whole[0].size());
  parallel_for(0, 3 * static_cast<int>(parts.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const size_t c = i % 3;
      solved[i / 3][c] = solve_patch_gains(equations, parts[i / 3], c, stations, guess[c]);
    }
  });
  return solved;
}

RoomPatches finished(const RoomPatches& solved, const WholeGains& whole) {
  return {finished(solved[0], whole[0]), finished(solved[1], whole[1]),
          finished(solved[2], whole[2])};
}

PatchGains station_of(const RoomPatches& patches, size_t station) {
  const auto part = [&](size_t c) {
    return std::span(patches[c]).subspan(station * kPatches, kPatches);
  };
  return {part(0), part(1), part(2)};
}

// [station][patch]: whether a ratio tells the patch's gain.
std::vector<std::array<bool, kPatches>> measured_patches(const std::vector<StationRatios>& all,
                                                         size_t stations) {
  std::vector<std::array<bool, kPatches>> measured(stations);
  for (const StationRatios& ratios : all) {
    for (const PatchRatio& patch : ratios.patches) {
      measured[static_cast<size_t>(ratios.from)][static_cast<size_t>(patch.from)] = true;
      measured[static_cast<size_t>(ratios.to)][static_cast<size_t>(patch.to)] = true;
    }
  }
  return measured;
}

// Whether any gain would be kept if the halves, which take twice as long to solve for, agreed.
bool could_be_significant(const RoomPatches& patches,
                          std::span<const std::array<bool, kPatches>> measured) {
  for (size_t i = 0; i < measured.size(); ++i) {
    const PatchGains gains = station_of(patches, i);
    const KeptGains kept = keep_significant(gains, {gains, gains}, measured[i]);
    if (kept.local || kept.whole != std::array<double, 3>{}) return true;
  }
  return false;
}

void multiply(const KeptGains& kept, GainField* field) {
  for (int c = 0; c < 3; ++c) {
    field->whole[c] *= static_cast<float>(std::exp(kept.whole[static_cast<size_t>(c)]));
  }
  if (!kept.local) return;
  field->local.create(kPatchesTheta, kPatchesPhi, CV_32FC3);
  for (int patch = 0; patch < kPatches; ++patch) {
    auto& gain = field->local.at<cv::Vec3f>(patch / kPatchesPhi, patch % kPatchesPhi);
    for (int c = 0; c < 3; ++c) {
      const auto& log_gains = kept.patches[static_cast<size_t>(c)];
      gain[c] = static_cast<float>(std::exp(log_gains[static_cast<size_t>(patch)]));
    }
  }
}

// Solves for the gains of a window's stations and multiplies those of `fields` that it keeps.
void solve_window(const GainWindow& window, std::span<const StationIndex> stations,
                  const RatioFile& file, const WholeGains& of_all, GainFields* fields) {
  std::vector<StationRatios> all = ratios_within(window, file);
  const WholeGains whole = whole_within(window, of_all);
  const std::vector<PatchEquation> equations = equations_of(all, whole);
  const auto measured = measured_patches(all, window.stations.size());
  all = {};  // frees the memory
  const RoomPatches solved =
      solve_parts(equations, std::array{Part::kAll}, whole, RoomPatches{}).front();
  const RoomPatches patches = finished(solved, whole);
  if (!could_be_significant(patches, measured)) return;
  const std::vector<RoomPatches> halves =
      solve_parts(equations, std::array{Part::kBlack, Part::kWhite}, whole, solved);
  const RoomPatches black = finished(halves[0], whole);
  const RoomPatches white = finished(halves[1], whole);
  for (size_t i = 0; i < window.stations.size(); ++i) {
    if (!window.kept[i]) continue;
    const StationIndex station = stations[static_cast<size_t>(window.stations[i])];
    const KeptGains kept = keep_significant(
        station_of(patches, i), {station_of(black, i), station_of(white, i)}, measured[i]);
    multiply(kept,
             &(*fields)[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)]);
  }
}

}  // namespace

GainFields solve_room_gains(const Room& room, std::span<const StationIndex> stations,
                            const SurfaceMaps& maps, int most_at_once) {
  RatioFile file(room.directory(), stations.size());
  const std::vector<WholeRatio> ratios = measure_ratios(room, stations, maps, &file);
  WholeGains whole;
  for (size_t c = 0; c < 3; ++c) {
    whole[c] = whole_gains(ratios, c, static_cast<int>(stations.size()));
  }
  std::vector<Eigen::Vector3d> positions_m;
  for (const StationIndex station : stations) {
    positions_m.push_back(position_of(room.grid(), station));
  }
  GainFields fields = unit_gain_fields(room.grid());
  const std::vector<GainWindow> windows = gain_windows(positions_m, ratios, most_at_once);
  Progress progress("solving for gains", static_cast<std::int64_t>(windows.size()), "windows");
  for (const GainWindow& window : windows) {
    throw_if_interrupted();
    solve_window(window, stations, file, whole, &fields);
    progress.advance();
  }
  return fields;
}

}  // namespace raywalk::build_lf
