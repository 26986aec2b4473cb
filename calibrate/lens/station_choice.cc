#include "calibrate/lens/station_choice.h"

#include <algorithm>

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kLeastPerLine = 5;

// `count` of the items, evenly spaced, including the ends.
std::vector<int> evenly(const std::vector<int>& items, std::size_t count) {
  if (count >= items.size()) return items;
  if (count == 1) return {items[items.size() / 2]};
  const std::size_t gaps = count - 1, last = items.size() - 1;
  std::vector<int> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    // i last / gaps, rounded to the nearest.
    chosen.push_back(items[(2 * i * last + gaps) / (2 * gaps)]);
  }
  return chosen;
}

// Alternating along x and along z, evenly spaced on each axis, in the order of the set.
std::vector<int> choose_lines(const CaptureSet& set, std::size_t count) {
  std::vector<int> along_x, along_z;
  for (std::size_t i = 0; i < set.lines.size(); ++i) {
    (set.lines[i].axis == LineAxis::kX ? along_x : along_z).push_back(static_cast<int>(i));
  }
  const std::size_t others = count - std::min(count, along_x.size());
  const std::size_t of_z = std::min(along_z.size(), std::max(count / 2, others));
  std::vector<int> chosen = evenly(along_x, count - of_z);
  const std::vector<int> chosen_z = evenly(along_z, of_z);
  chosen.insert(chosen.end(), chosen_z.begin(), chosen_z.end());
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace

std::vector<std::size_t> choose_stations(const CaptureSet& set, std::size_t count) {
  if (set.lines.empty()) return {};
  const std::size_t lines = std::clamp<std::size_t>(count / kLeastPerLine, 1, set.lines.size());
  std::vector<std::size_t> stations;
  for (const int line : choose_lines(set, lines)) {
    const std::vector<int>& frames = set.lines[static_cast<std::size_t>(line)].frames;
    const std::vector<int> chosen = evenly(frames, std::max(count / lines, kLeastPerLine));
    stations.insert(stations.end(), chosen.begin(), chosen.end());
  }
  return stations;
}

std::vector<StationPair> pairs_to_match(const CaptureSet& set,
                                        const std::vector<std::size_t>& stations) {
  const auto on_one_line = [&](std::size_t i, std::size_t j) {
    return set.frames[stations[i]].line == set.frames[stations[j]].line;
  };
  const auto apart_m = [&](std::size_t i, std::size_t j) {
    return set.nominal_distance_m(stations[i], stations[j]);
  };
  double largest_step_m = 0.0;  // between chosen neighbours on a line
  for (std::size_t i = 1; i < stations.size(); ++i) {
    if (on_one_line(i - 1, i)) largest_step_m = std::max(largest_step_m, apart_m(i - 1, i));
  }
  std::vector<StationPair> pairs;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (std::size_t j = i + 1; j < stations.size(); ++j) {
      const bool near = on_one_line(i, j) ? j - i <= 2 : apart_m(i, j) <= largest_step_m;
      if (near) pairs.push_back({i, j});
    }
  }
  return pairs;
}

}  // namespace raywalk::calibrate
