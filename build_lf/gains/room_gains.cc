#include "build_lf/gains/room_gains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>

#include "build_lf/gains/gain_significance.h"
#include "build_lf/gains/gain_solver.h"
#include "build_lf/gains/gain_spots.h"
#include "build_lf/gains/patch_ratios.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/robust_sigma.h"
#include "core/files/packed_values.h"
#include "core/panorama/gain_graph.h"

namespace raywalk::build_lf {
namespace {

Eigen::Vector3d position_of(const Room& room, StationIndex station) {
  const Line& line = room.grid().lines[static_cast<size_t>(station.line)];
  return line.stations[static_cast<size_t>(station.station)].position_m;
}

// The stations with maps that a station is compared with: the nearest on its own line, where the
// views are most alike, and the nearest on others, which tie the lines together.
std::vector<StationIndex> partners_of(const Room& room, StationIndex station,
                                      const SurfaceMaps& maps) {
  constexpr int kOwn = 4;
  constexpr int kOthers = 6;
  const Eigen::Vector3d here_m = position_of(room, station);
  std::vector<StationIndex> order;
  for (const StationIndex other : maps.stations) {
    if (other != station) order.push_back(other);
  }
  std::stable_sort(order.begin(), order.end(), [&](StationIndex a, StationIndex b) {
    return (position_of(room, a) - here_m).squaredNorm() <
           (position_of(room, b) - here_m).squaredNorm();
  });
  std::vector<StationIndex> partners;
  int own = 0;
  int others = 0;
  for (const StationIndex other : order) {
    const bool same_line = other.line == station.line;
    int& count = same_line ? own : others;
    if (count == (same_line ? kOwn : kOthers)) continue;
    ++count;
    partners.push_back(other);
  }
  return partners;
}

// Pictures and maps of the stations that a run of consecutive stations is compared with; these are
// mostly the same.
class Surfaces {
 public:
  Surfaces(const Room& room, const SurfaceMaps& maps) : room_(room), maps_(maps) {}

  const SurfacePicture& picture(StationIndex station) {
    const auto found = pictures_.find(station);
    if (found != pictures_.end()) return found->second;
    return pictures_.emplace(station, surface_picture(room_, station, maps_.size, maps_.valid))
        .first->second;
  }

  // Null if the station has none.
  const InverseDistanceMap* map(StationIndex station) {
    const auto found = read_.find(station);
    if (found != read_.end()) return &found->second;
    if (!std::binary_search(maps_.stations.begin(), maps_.stations.end(), station)) return nullptr;
    return &read_.emplace(station, maps_.read(station)).first->second;
  }

 private:
  const Room& room_;
  const SurfaceMaps& maps_;
  std::map<StationIndex, SurfacePicture> pictures_;
  std::map<StationIndex, InverseDistanceMap> read_;
};

// What a station's initial gains add to a log ratio is taken off, so that the rest is solved for.
void take_off(const GainFields& initial, std::span<const StationIndex> stations,
              std::vector<StationRatios>* all) {
  const auto log_gains = [&](int number) {
    const StationIndex station = stations[static_cast<size_t>(number)];
    const ColourGain& whole =
        initial[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)].whole;
    return std::array<float, 3>{std::log(whole[0]), std::log(whole[1]), std::log(whole[2])};
  };
  for (StationRatios& ratios : *all) {
    const auto from = log_gains(ratios.from);
    const auto to = log_gains(ratios.to);
    for (PatchRatio& patch : ratios.patches) {
      for (size_t c = 0; c < 3; ++c) patch.log_ratio[c] -= from[c] - to[c];
    }
  }
}

// The log gains of whole pictures in one channel: two pictures differ by the median of their
// patches.
std::vector<double> whole_gains(const std::vector<StationRatios>& all, size_t channel,
                                int stations) {
  constexpr double kModelError = 0.005;
  std::vector<GainEquation> equations;
  for (const StationRatios& ratios : all) {
    if (ratios.patches.empty()) continue;
    std::vector<double> values;
    for (const PatchRatio& patch : ratios.patches) {
      values.push_back(static_cast<double>(patch.log_ratio[channel]));
    }
    const double middle = median(values);
    const auto count = static_cast<double>(values.size());
    for (double& value : values) value = std::fabs(value - middle);
    const double error = robust_sigma(std::move(values)) / std::sqrt(count);
    equations.push_back({ratios.from, ratios.to, middle, std::hypot(error, kModelError)});
  }
  const Eigen::VectorXd solved = solve_gain_graph(equations, stations);
  return {solved.data(), solved.data() + solved.size()};
}

// Log gains of whole pictures, [channel][station].
using WholeGains = std::array<std::vector<double>, 3>;

// The ratios less those of the whole pictures' gains.
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

}  // namespace

std::vector<StationRatios> compare_stations(const Room& room,
                                            std::span<const StationIndex> stations,
                                            const SurfaceMaps& maps, IndexRange share) {
  std::map<StationIndex, int> number;
  for (const StationIndex station : stations) {
    number.emplace(station, static_cast<int>(number.size()));
  }
  std::vector<std::vector<StationRatios>> of_station(share.size());
  Progress progress("comparing surfaces", static_cast<std::int64_t>(share.size()), "stations");
  constexpr int kStationsPerTask = 8;
  parallel_for(0, static_cast<int>(share.size()), kStationsPerTask, [&](int begin, int end) {
    Surfaces surfaces(room, maps);
    for (int i = begin; i < end; ++i) {
      const std::size_t number_of_to = share.begin + static_cast<size_t>(i);
      const StationIndex to = stations[number_of_to];
      for (const StationIndex from : partners_of(room, to, maps)) {
        const auto from_number = number.find(from);
        if (from_number == number.end()) continue;
        std::vector<PatchRatio> patches = compare_surfaces(
            surfaces.picture(from), *surfaces.map(from), surfaces.picture(to), surfaces.map(to));
        of_station[static_cast<size_t>(i)].push_back(
            {from_number->second, static_cast<int>(number_of_to), std::move(patches)});
      }
      progress.advance();
    }
  });
  std::vector<StationRatios> all;
  for (std::vector<StationRatios>& ratios : of_station) {
    std::move(ratios.begin(), ratios.end(), std::back_inserter(all));
  }
  return all;
}

std::string bytes_of(const std::vector<StationRatios>& ratios) {
  PackedWriter writer;
  for (const StationRatios& of_pair : ratios) {
    writer.add(of_pair.from);
    writer.add(of_pair.to);
    writer.add_all(of_pair.patches);
  }
  return writer.bytes();
}

std::vector<StationRatios> ratios_of(std::string_view bytes) {
  static_assert(sizeof(PatchRatio) == 8 * sizeof(float), "nothing between its members");
  std::vector<StationRatios> ratios;
  for (PackedReader reader(bytes); !reader.at_end();) {
    StationRatios& of_pair = ratios.emplace_back();
    of_pair.from = reader.next<int>();
    of_pair.to = reader.next<int>();
    of_pair.patches = reader.next_all<PatchRatio>();
  }
  return ratios;
}

GainFields solve_room_gains(const Room& room, std::span<const StationIndex> stations,
                            const SurfaceMaps& maps, const GainFields& initial) {
  return solve_room_gains(stations, compare_stations(room, stations, maps, {0, stations.size()}),
                          initial);
}

GainFields solve_room_gains(std::span<const StationIndex> stations,
                            std::vector<StationRatios> ratios, const GainFields& initial) {
  take_off(initial, stations, &ratios);
  WholeGains whole;
  for (size_t c = 0; c < 3; ++c)
    whole[c] = whole_gains(ratios, c, static_cast<int>(stations.size()));
  const std::vector<PatchEquation> equations = equations_of(ratios, whole);
  const auto measured = measured_patches(ratios, stations.size());
  ratios = {};  // frees the memory
  const RoomPatches solved =
      solve_parts(equations, std::array{Part::kAll}, whole, RoomPatches{}).front();
  const RoomPatches patches = finished(solved, whole);
  if (!could_be_significant(patches, measured)) return initial;
  const std::vector<RoomPatches> halves =
      solve_parts(equations, std::array{Part::kBlack, Part::kWhite}, whole, solved);
  const RoomPatches black = finished(halves[0], whole);
  const RoomPatches white = finished(halves[1], whole);
  GainFields fields = initial;
  for (size_t i = 0; i < stations.size(); ++i) {
    const KeptGains kept = keep_significant(
        station_of(patches, i), {station_of(black, i), station_of(white, i)}, measured[i]);
    multiply(
        kept,
        &fields[static_cast<size_t>(stations[i].line)][static_cast<size_t>(stations[i].station)]);
  }
  return fields;
}

}  // namespace raywalk::build_lf
