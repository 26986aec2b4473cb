#include "calibrate/poses/match_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr double kReachAlong = 0.25;  // of the cell's side
constexpr double kReachAcross = 0.2;  // to each side of an intersection
constexpr int kAcross = 5;            // keyframes of each line at an intersection
constexpr std::size_t kAtJoint = 4;   // keyframes of each of two placements of the rail on a line

// Of a line, by rail position.
using Frames = std::vector<std::size_t>;

// Rail position of an intersection on one of its lines.
double rail_position_m(const CaptureLine& line, PlanPoint intersection) {
  return line.axis == LineAxis::kX ? intersection.x_m : intersection.z_m;
}

// By line: rail positions of its intersections in ascending order.
std::vector<std::vector<double>> intersection_positions(
    const CaptureSet& set, std::span<const LineIntersection> intersections) {
  std::vector<std::vector<double>> positions(set.lines.size());
  for (const LineIntersection& intersection : intersections) {
    for (const std::size_t line : {intersection.along_x, intersection.along_z}) {
      positions[line].push_back(rail_position_m(set.lines[line], intersection.at));
    }
  }
  for (std::vector<double>& of_line : positions) std::sort(of_line.begin(), of_line.end());
  return positions;
}

double length_m(const CaptureSet& set, const CaptureLine& line) {
  return line.frames.empty()
             ? 0.0
             : std::abs(set.rail_m(line.frames.back()) - set.rail_m(line.frames.front()));
}

// The last frame before a rail position and the first one behind it.
Frames around(const CaptureSet& set, const Frames& frames, double at_m) {
  const auto behind = std::find_if(frames.begin(), frames.end(),
                                   [&](std::size_t frame) { return set.rail_m(frame) >= at_m; });
  Frames found;
  if (behind != frames.begin()) found.push_back(*(behind - 1));
  if (behind != frames.end()) found.push_back(*behind);
  return found;
}

// Marks further stations so that marked neighbours are at most `gap_m` apart, where stations are
// dense enough.
void mark_between(const CaptureSet& set, const Frames& stations, double gap_m,
                  std::vector<bool>* chosen) {
  // Tolerance for the slider's feedback, which is far more exact.
  const double reach_m = gap_m * 1.001;
  std::size_t last = stations.front();
  for (std::size_t i = 1; i < stations.size(); ++i) {
    const bool next_is_too_far =
        i + 1 < stations.size() && set.rail_m(stations[i + 1]) - set.rail_m(last) > reach_m;
    if (!(*chosen)[stations[i]] && !next_is_too_far) continue;
    (*chosen)[stations[i]] = true;
    last = stations[i];
  }
}

// The keyframes of a line, by rail position.
Frames keyframes_of(const CaptureLine& line, std::span<const std::size_t> keyframes) {
  Frames of_line;
  std::copy_if(line.frames.begin(), line.frames.end(), std::back_inserter(of_line),
               [&](std::size_t frame) {
                 return std::binary_search(keyframes.begin(), keyframes.end(), frame);
               });
  return of_line;
}

void add_pair(std::size_t a, std::size_t b, std::set<FramePair>* pairs) {
  if (a != b) pairs->insert({std::min(a, b), std::max(a, b)});
}

// Offsets of a keyframe's partners in keyframes: 1, 4, 16, ... within the reach. If only 1 is, then
// also 2, so that a bad picture does not cut the line in two.
std::vector<std::size_t> steps_along(const CaptureSet& set, const Frames& frames, std::size_t from,
                                     double reach_m) {
  std::vector<std::size_t> steps{1};
  for (std::size_t step = 4; from + step < frames.size(); step *= 4) {
    if (std::abs(set.rail_m(frames[from + step]) - set.rail_m(frames[from])) > reach_m) break;
    steps.push_back(step);
  }
  if (steps.size() == 1) steps.push_back(2);
  return steps;
}

void add_along(const CaptureSet& set, const Frames& frames, double reach_m,
               std::set<FramePair>* pairs) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const std::size_t step : steps_along(set, frames, i, reach_m)) {
      if (i + step < frames.size()) add_pair(frames[i], frames[i + step], pairs);
    }
  }
}

// Two placements of the rail, one behind the other on one line, see the same surroundings at their
// joint: their stations there are neighbours as those of one placement are.
void add_joints(const CaptureSet& set, const std::vector<Frames>& by_line, double reach_m,
                std::set<FramePair>* pairs) {
  for (std::size_t i = 1; i < set.lines.size(); ++i) {
    const CaptureLine &before = set.lines[i - 1], &behind = set.lines[i];
    if (before.axis != behind.axis || before.across_m != behind.across_m) continue;
    const auto last = std::span(by_line[i - 1]).last(std::min(by_line[i - 1].size(), kAtJoint));
    const auto first = std::span(by_line[i]).first(std::min(by_line[i].size(), kAtJoint));
    Frames frames(last.begin(), last.end());
    frames.insert(frames.end(), first.begin(), first.end());
    add_along(set, frames, reach_m, pairs);
  }
}

// The keyframes nearest to kAcross positions spread over the reach, without duplicates.
Frames spread_around(const CaptureSet& set, const Frames& frames, double at_m, double reach_m) {
  std::set<std::size_t> chosen;
  for (int i = 0; i < kAcross && !frames.empty(); ++i) {
    const double place_m = at_m + reach_m * (2.0 * i / (kAcross - 1) - 1.0);
    chosen.insert(
        *std::min_element(frames.begin(), frames.end(), [&](std::size_t a, std::size_t b) {
          return std::abs(set.rail_m(a) - place_m) < std::abs(set.rail_m(b) - place_m);
        }));
  }
  return {chosen.begin(), chosen.end()};
}

double plan_distance_m(const CaptureFrame& a, const CaptureFrame& b) {
  return std::hypot(a.nominal_m.x() - b.nominal_m.x(), a.nominal_m.z() - b.nominal_m.z());
}

// Lines with keyframes, those nearest to a frame.
std::vector<std::size_t> nearest_lines(const CaptureSet& set, const CaptureFrame& held_out,
                                       const std::vector<Frames>& by_line) {
  constexpr std::size_t kLines = 2;
  std::vector<std::pair<double, std::size_t>> lines;
  for (std::size_t line = 0; line < by_line.size(); ++line) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const std::size_t frame : by_line[line]) {
      least_m = std::min(least_m, plan_distance_m(held_out, set.frames[frame]));
    }
    if (!by_line[line].empty()) lines.emplace_back(least_m, line);
  }
  std::sort(lines.begin(), lines.end());
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < std::min(kLines, lines.size()); ++i) {
    nearest.push_back(lines[i].second);
  }
  return nearest;
}

void add_held_out(const CaptureSet& set, std::size_t index, const std::vector<Frames>& by_line,
                  double reach_m, std::set<FramePair>* pairs) {
  const CaptureFrame& held_out = set.frames[index];
  const PlanPoint place{held_out.nominal_m.x(), held_out.nominal_m.z()};
  for (const std::size_t line : nearest_lines(set, held_out, by_line)) {
    const double at_m = rail_position_m(set.lines[line], place);
    for (const std::size_t frame : around(set, by_line[line], at_m)) add_pair(index, frame, pairs);
    for (const std::size_t frame : spread_around(set, by_line[line], at_m, reach_m)) {
      add_pair(index, frame, pairs);
    }
  }
}

}  // namespace

double cell_side_m(const CaptureSet& set, std::span<const LineIntersection> intersections) {
  std::vector<double> sides;
  for (const std::vector<double>& positions : intersection_positions(set, intersections)) {
    for (std::size_t i = 1; i < positions.size(); ++i) {
      sides.push_back(positions[i] - positions[i - 1]);
    }
  }
  if (!sides.empty() && median(sides) > 0.0) return median(sides);
  double longest_m = 0.0;
  for (const CaptureLine& line : set.lines) longest_m = std::max(longest_m, length_m(set, line));
  return longest_m * 2.0 / 3.0;
}

std::vector<std::size_t> choose_keyframes(const CaptureSet& set,
                                          std::span<const LineIntersection> intersections,
                                          double keyframes_mm) {
  std::vector<bool> chosen(set.frames.size(), keyframes_mm <= 0.0);
  const std::vector<std::vector<double>> positions = intersection_positions(set, intersections);
  for (std::size_t i = 0; i < set.lines.size() && keyframes_mm > 0.0; ++i) {
    const Frames stations(set.lines[i].frames.begin(), set.lines[i].frames.end());
    if (stations.empty()) continue;
    chosen[stations.front()] = chosen[stations.back()] = true;
    for (const double at_m : positions[i]) {
      for (const std::size_t station : around(set, stations, at_m)) chosen[station] = true;
    }
    mark_between(set, stations, keyframes_mm * 1e-3, &chosen);
  }
  std::vector<std::size_t> keyframes;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] || set.frames[i].held_out()) keyframes.push_back(i);
  }
  return keyframes;
}

std::vector<FramePair> choose_pairs(const CaptureSet& set,
                                    std::span<const LineIntersection> intersections,
                                    std::span<const std::size_t> keyframes) {
  const double side_m = cell_side_m(set, intersections);
  std::vector<Frames> by_line;
  by_line.reserve(set.lines.size());
  for (const CaptureLine& line : set.lines) by_line.push_back(keyframes_of(line, keyframes));
  std::set<FramePair> pairs;
  for (const Frames& frames : by_line) add_along(set, frames, kReachAlong * side_m, &pairs);
  add_joints(set, by_line, kReachAlong * side_m, &pairs);
  for (const LineIntersection& intersection : intersections) {
    const auto near = [&](std::size_t line) {
      return spread_around(set, by_line[line], rail_position_m(set.lines[line], intersection.at),
                           kReachAcross * side_m);
    };
    const Frames along_z = near(intersection.along_z);
    for (const std::size_t a : near(intersection.along_x)) {
      for (const std::size_t b : along_z) add_pair(a, b, &pairs);
    }
  }
  for (const std::size_t frame : keyframes) {
    if (!set.frames[frame].held_out()) continue;
    add_held_out(set, frame, by_line, kReachAcross * side_m, &pairs);
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace raywalk::calibrate
