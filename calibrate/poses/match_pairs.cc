#include "calibrate/poses/match_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr double kReachAlong = 0.25;  // of the cell's side
constexpr double kReachAcross = 0.2;  // to each side of a crossing
constexpr int kAcross = 5;            // keyframes of each line at a crossing
constexpr std::size_t kAtJoint = 4;   // keyframes of each of two placements of the rail on a line

// Rail position of a crossing on one of its lines.
double rail_position_m(const CaptureLine& line, PlanPoint crossing) {
  return line.axis == LineAxis::kX ? crossing.x_m : crossing.z_m;
}

// By line: rail positions of its crossings in ascending order.
std::vector<std::vector<double>> crossing_positions(const CaptureSet& set,
                                                    std::span<const LineCrossing> crossings) {
  std::vector<std::vector<double>> positions(set.lines.size());
  for (const LineCrossing& crossing : crossings) {
    for (const int line : {crossing.along_x, crossing.along_z}) {
      const auto index = static_cast<std::size_t>(line);
      positions[index].push_back(rail_position_m(set.lines[index], crossing.at));
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

// Marks the stations around a position: the last one before it and the first one behind it.
void mark_around(const CaptureSet& set, const CaptureLine& line, double at_m,
                 std::vector<bool>* chosen) {
  const auto behind = std::find_if(line.frames.begin(), line.frames.end(),
                                   [&](int frame) { return set.rail_m(frame) >= at_m; });
  if (behind != line.frames.end()) (*chosen)[static_cast<std::size_t>(*behind)] = true;
  if (behind != line.frames.begin()) (*chosen)[static_cast<std::size_t>(*(behind - 1))] = true;
}

// Marks further stations so that marked neighbours are at most `gap_m` apart, where stations are
// dense enough.
void mark_between(const CaptureSet& set, const CaptureLine& line, double gap_m,
                  std::vector<bool>* chosen) {
  const std::vector<int>& frames = line.frames;
  // Tolerance for the slider's feedback, which is far more exact.
  const double reach_m = gap_m * 1.001;
  int last = frames.front();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const bool taken = (*chosen)[static_cast<std::size_t>(frames[i])];
    const bool next_is_too_far =
        i + 1 < frames.size() && set.rail_m(frames[i + 1]) - set.rail_m(last) > reach_m;
    if (!taken && !next_is_too_far) continue;
    (*chosen)[static_cast<std::size_t>(frames[i])] = true;
    last = frames[i];
  }
}

// The keyframes of a line, by rail position.
std::vector<int> keyframes_of(const CaptureLine& line, std::span<const int> keyframes) {
  std::vector<int> of_line;
  std::copy_if(line.frames.begin(), line.frames.end(), std::back_inserter(of_line), [&](int frame) {
    return std::binary_search(keyframes.begin(), keyframes.end(), frame);
  });
  return of_line;
}

void add_pair(int a, int b, std::set<FramePair>* pairs) {
  if (a != b) pairs->insert({std::min(a, b), std::max(a, b)});
}

// Offsets of a keyframe's partners in keyframes: 1, 4, 16, ... within the reach. If only 1 is, then
// also 2, so that a bad picture does not cut the line in two.
std::vector<std::size_t> steps_along(const CaptureSet& set, const std::vector<int>& frames,
                                     std::size_t from, double reach_m) {
  std::vector<std::size_t> steps{1};
  for (std::size_t step = 4; from + step < frames.size(); step *= 4) {
    if (std::abs(set.rail_m(frames[from + step]) - set.rail_m(frames[from])) > reach_m) break;
    steps.push_back(step);
  }
  if (steps.size() == 1) steps.push_back(2);
  return steps;
}

void add_along(const CaptureSet& set, const std::vector<int>& frames, double reach_m,
               std::set<FramePair>* pairs) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const std::size_t step : steps_along(set, frames, i, reach_m)) {
      if (i + step < frames.size()) add_pair(frames[i], frames[i + step], pairs);
    }
  }
}

// Two placements of the rail, one behind the other on one line, see the same surroundings at their
// joint: their stations there are neighbours as those of one placement are.
void add_joints(const CaptureSet& set, const std::vector<std::vector<int>>& by_line, double reach_m,
                std::set<FramePair>* pairs) {
  for (std::size_t i = 1; i < set.lines.size(); ++i) {
    const CaptureLine &before = set.lines[i - 1], &behind = set.lines[i];
    if (before.axis != behind.axis || before.across_m != behind.across_m) continue;
    std::vector<int> frames(by_line[i - 1].end() - static_cast<std::ptrdiff_t>(
                                                       std::min(by_line[i - 1].size(), kAtJoint)),
                            by_line[i - 1].end());
    frames.insert(
        frames.end(), by_line[i].begin(),
        by_line[i].begin() + static_cast<std::ptrdiff_t>(std::min(by_line[i].size(), kAtJoint)));
    add_along(set, frames, reach_m, pairs);
  }
}

// The keyframes nearest to kAcross positions spread over the reach, without duplicates.
std::vector<int> spread_around(const CaptureSet& set, const std::vector<int>& frames, double at_m,
                               double reach_m) {
  std::set<int> chosen;
  for (int i = 0; i < kAcross && !frames.empty(); ++i) {
    const double place_m = at_m + reach_m * (2.0 * i / (kAcross - 1) - 1.0);
    chosen.insert(*std::min_element(frames.begin(), frames.end(), [&](int a, int b) {
      return std::abs(set.rail_m(a) - place_m) < std::abs(set.rail_m(b) - place_m);
    }));
  }
  return {chosen.begin(), chosen.end()};
}

double plan_distance_m(const CaptureFrame& a, const CaptureFrame& b) {
  return std::hypot(a.nominal_m.x() - b.nominal_m.x(), a.nominal_m.z() - b.nominal_m.z());
}

// The last keyframe before a rail position and the first one behind it.
std::vector<int> around(const CaptureSet& set, const std::vector<int>& frames, double at_m) {
  const auto behind = std::find_if(frames.begin(), frames.end(),
                                   [&](int frame) { return set.rail_m(frame) >= at_m; });
  std::vector<int> found;
  if (behind != frames.begin()) found.push_back(*(behind - 1));
  if (behind != frames.end()) found.push_back(*behind);
  return found;
}

// Lines with keyframes, those nearest to a frame.
std::vector<std::size_t> nearest_lines(const CaptureSet& set, const CaptureFrame& held_out,
                                       const std::vector<std::vector<int>>& by_line) {
  constexpr std::size_t kLines = 2;
  std::vector<std::pair<double, std::size_t>> lines;
  for (std::size_t line = 0; line < by_line.size(); ++line) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const int frame : by_line[line]) {
      least_m =
          std::min(least_m, plan_distance_m(held_out, set.frames[static_cast<std::size_t>(frame)]));
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

void add_held_out(const CaptureSet& set, int index, const std::vector<std::vector<int>>& by_line,
                  double reach_m, std::set<FramePair>* pairs) {
  const CaptureFrame& held_out = set.frames[static_cast<std::size_t>(index)];
  const PlanPoint place{held_out.nominal_m.x(), held_out.nominal_m.z()};
  for (const std::size_t line : nearest_lines(set, held_out, by_line)) {
    const double at_m = rail_position_m(set.lines[line], place);
    for (const int frame : around(set, by_line[line], at_m)) add_pair(index, frame, pairs);
    for (const int frame : spread_around(set, by_line[line], at_m, reach_m)) {
      add_pair(index, frame, pairs);
    }
  }
}

}  // namespace

double cell_side_m(const CaptureSet& set, std::span<const LineCrossing> crossings) {
  std::vector<double> sides;
  for (const std::vector<double>& positions : crossing_positions(set, crossings)) {
    for (std::size_t i = 1; i < positions.size(); ++i) {
      sides.push_back(positions[i] - positions[i - 1]);
    }
  }
  if (!sides.empty() && median(sides) > 0.0) return median(sides);
  double longest_m = 0.0;
  for (const CaptureLine& line : set.lines) longest_m = std::max(longest_m, length_m(set, line));
  return longest_m * 2.0 / 3.0;
}

std::vector<int> choose_keyframes(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                  double keyframes_mm) {
  std::vector<bool> chosen(set.frames.size(), keyframes_mm <= 0.0);
  const std::vector<std::vector<double>> positions = crossing_positions(set, crossings);
  for (std::size_t i = 0; i < set.lines.size() && keyframes_mm > 0.0; ++i) {
    const CaptureLine& line = set.lines[i];
    if (line.frames.empty()) continue;
    chosen[static_cast<std::size_t>(line.frames.front())] = true;
    chosen[static_cast<std::size_t>(line.frames.back())] = true;
    for (const double at_m : positions[i]) mark_around(set, line, at_m, &chosen);
    mark_between(set, line, keyframes_mm * 1e-3, &chosen);
  }
  std::vector<int> keyframes;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] || set.frames[i].held_out()) keyframes.push_back(static_cast<int>(i));
  }
  return keyframes;
}

std::vector<FramePair> choose_pairs(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                    std::span<const int> keyframes) {
  const double side_m = cell_side_m(set, crossings);
  std::vector<std::vector<int>> by_line;
  for (const CaptureLine& line : set.lines) by_line.push_back(keyframes_of(line, keyframes));
  std::set<FramePair> pairs;
  for (const std::vector<int>& frames : by_line) {
    add_along(set, frames, kReachAlong * side_m, &pairs);
  }
  add_joints(set, by_line, kReachAlong * side_m, &pairs);
  for (const LineCrossing& crossing : crossings) {
    const auto near = [&](int line) {
      const auto index = static_cast<std::size_t>(line);
      return spread_around(set, by_line[index], rail_position_m(set.lines[index], crossing.at),
                           kReachAcross * side_m);
    };
    const std::vector<int> along_z = near(crossing.along_z);
    for (const int a : near(crossing.along_x)) {
      for (const int b : along_z) add_pair(a, b, &pairs);
    }
  }
  for (const int frame : keyframes) {
    if (!set.frames[static_cast<std::size_t>(frame)].held_out()) continue;
    add_held_out(set, frame, by_line, kReachAcross * side_m, &pairs);
  }
  return {pairs.begin(), pairs.end()};
}

std::vector<FacePair> overlapping_faces(const std::array<PanoramaFace, kFaceCount>& faces,
                                        const Eigen::Matrix3d& world_from_first,
                                        const Eigen::Matrix3d& world_from_second) {
  static const double kSame = std::cos(radians_from_degrees(20.0));
  static const double kOverlapping = std::cos(radians_from_degrees(60.0));
  std::vector<FacePair> pairs;
  for (int first = 0; first < kFaceCount; ++first) {
    const auto axis = [&](const Eigen::Matrix3d& world_from_camera, int face) {
      return Eigen::Vector3d(world_from_camera *
                             faces[static_cast<std::size_t>(face)].camera_from_face.col(2));
    };
    std::array<double, kFaceCount> cosines{};
    for (int second = 0; second < kFaceCount; ++second) {
      cosines[static_cast<std::size_t>(second)] =
          axis(world_from_first, first).dot(axis(world_from_second, second));
    }
    const double best = *std::max_element(cosines.begin(), cosines.end());
    for (int second = 0; second < kFaceCount; ++second) {
      const double cosine = cosines[static_cast<std::size_t>(second)];
      if (cosine == best || (best < kSame && cosine > kOverlapping)) {
        pairs.push_back({first, second});
      }
    }
  }
  return pairs;
}

}  // namespace raywalk::calibrate
