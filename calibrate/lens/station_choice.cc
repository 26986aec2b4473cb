#include "calibrate/lens/station_choice.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr int kLeastPerLine = 5;

// `count` of the numbers 0 ... size - 1, evenly spaced, including the ends.
std::vector<int> evenly(int size, int count) {
  std::vector<int> chosen;
  if (count >= size) {
    for (int i = 0; i < size; ++i) chosen.push_back(i);
    return chosen;
  }
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.5 : static_cast<double>(i) / (count - 1);
    chosen.push_back(static_cast<int>(std::lround(share * (size - 1))));
  }
  return chosen;
}

// Alternating along x and along z, evenly spaced on each axis, in the order of the set.
std::vector<int> choose_lines(const CaptureSet& set, int count) {
  std::vector<int> along_x, along_z;
  for (std::size_t i = 0; i < set.lines.size(); ++i) {
    (set.lines[i].axis == LineAxis::kX ? along_x : along_z).push_back(static_cast<int>(i));
  }
  const int all_x = static_cast<int>(along_x.size()), all_z = static_cast<int>(along_z.size());
  const int of_z = std::min(all_z, std::max(count / 2, count - all_x));
  std::vector<int> chosen;
  for (const int i : evenly(all_x, std::min(all_x, count - of_z))) {
    chosen.push_back(along_x[static_cast<std::size_t>(i)]);
  }
  for (const int i : evenly(all_z, of_z)) chosen.push_back(along_z[static_cast<std::size_t>(i)]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

const CaptureFrame& frame_of(const CaptureSet& set, int index) {
  return set.frames[static_cast<std::size_t>(index)];
}

double distance_m(const CaptureSet& set, int a, int b) {
  return (frame_of(set, a).nominal_m - frame_of(set, b).nominal_m).norm();
}

// The largest distance between chosen neighbours on a line.
double largest_step_m(const CaptureSet& set, const std::vector<int>& stations) {
  double largest = 0.0;
  for (std::size_t i = 1; i < stations.size(); ++i) {
    if (frame_of(set, stations[i - 1]).line != frame_of(set, stations[i]).line) continue;
    largest = std::max(largest, distance_m(set, stations[i - 1], stations[i]));
  }
  return largest;
}

}  // namespace

std::vector<int> choose_stations(const CaptureSet& set, int count) {
  const int lines = static_cast<int>(set.lines.size());
  const int lines_used = std::clamp(count / kLeastPerLine, std::min(1, lines), lines);
  std::vector<int> stations;
  for (const int line : choose_lines(set, lines_used)) {
    const std::vector<int>& frames = set.lines[static_cast<std::size_t>(line)].frames;
    const int share = std::max(count / lines_used, kLeastPerLine);
    for (const int i : evenly(static_cast<int>(frames.size()), share)) {
      stations.push_back(frames[static_cast<std::size_t>(i)]);
    }
  }
  return stations;
}

std::vector<StationPair> pairs_to_match(const CaptureSet& set, const std::vector<int>& stations) {
  const double near_m = largest_step_m(set, stations);
  std::vector<StationPair> pairs;
  const int count = static_cast<int>(stations.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const int a = stations[static_cast<std::size_t>(i)];
      const int b = stations[static_cast<std::size_t>(j)];
      const bool same_line = frame_of(set, a).line == frame_of(set, b).line;
      if (same_line ? j - i <= 2 : distance_m(set, a, b) <= near_m) pairs.push_back({i, j});
    }
  }
  return pairs;
}

}  // namespace raywalk::calibrate
