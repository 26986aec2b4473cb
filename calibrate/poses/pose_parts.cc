#include "calibrate/poses/pose_parts.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "calibrate/base/disjoint_sets.h"

namespace raywalk::calibrate {
namespace {

// Lines nearer to each other than this share of a cell's side are not cut apart.
constexpr double kLeastGap = 0.25;
// A cut leaves at least this share of the keyframes on either side.
constexpr double kLeastSide = 0.125;
// What is connected with less than this share of the largest part is no part of its own.
constexpr double kLeastPart = 0.1;
// Keyframes of a line that a part has beyond its home, at least: parts are joined by them.
constexpr std::ptrdiff_t kBeyondHome = 4;
constexpr int kNoPart = -1;

using Frames = std::vector<int>;

double at_m(const CaptureSet& set, int frame, LineAxis along) {
  const Eigen::Vector3d& place = set.frames[static_cast<std::size_t>(frame)].nominal_m;
  return along == LineAxis::kX ? place.x() : place.z();
}

double extent_m(const CaptureSet& set, const Frames& frames, LineAxis along) {
  const auto [least, most] = std::minmax_element(frames.begin(), frames.end(), [&](int a, int b) {
    return at_m(set, a, along) < at_m(set, b, along);
  });
  return at_m(set, *most, along) - at_m(set, *least, along);
}

// Where the lines across an axis are that have any of the frames, ascending.
std::vector<double> lines_across(const CaptureSet& set, const Frames& frames, LineAxis along) {
  std::vector<double> places_m;
  std::vector<bool> seen(set.lines.size(), false);
  for (const int frame : frames) {
    const auto line = static_cast<std::size_t>(set.frames[static_cast<std::size_t>(frame)].line);
    if (seen[line] || set.lines[line].axis == along) continue;
    seen[line] = true;
    places_m.push_back(set.lines[line].across_m);
  }
  std::sort(places_m.begin(), places_m.end());
  return places_m;
}

class Divider {
 public:
  Divider(const CaptureSet& set, double cell_m, int most) : set_(set), cell_m_(cell_m) {
    most_ = static_cast<std::size_t>(std::max(most, 1));
  }

  // Groups of neighbouring frames.
  std::vector<Frames> divide(const Frames& frames) {
    groups_.clear();
    divide_further(frames);
    return groups_;
  }

 private:
  void divide_further(const Frames& frames) {
    const std::size_t parts = (frames.size() + most_ - 1) / most_;
    if (parts <= 1) {
      if (!frames.empty()) groups_.push_back(frames);
      return;
    }
    const std::size_t wanted = frames.size() * (parts / 2) / parts;
    const LineAxis along =
        extent_m(set_, frames, LineAxis::kX) >= extent_m(set_, frames, LineAxis::kZ) ? LineAxis::kX
                                                                                     : LineAxis::kZ;
    Frames sorted = frames;
    std::sort(sorted.begin(), sorted.end(), [&](int a, int b) {
      return std::pair(at_m(set_, a, along), a) < std::pair(at_m(set_, b, along), b);
    });
    const std::size_t below = cut_between_lines(sorted, along, wanted).value_or(wanted);
    const auto cut = sorted.begin() + static_cast<std::ptrdiff_t>(below);
    Frames first(sorted.begin(), cut);
    Frames second(cut, sorted.end());
    std::sort(first.begin(), first.end());
    std::sort(second.begin(), second.end());
    divide_further(first);
    divide_further(second);
  }

  // The number of frames before the cut that comes nearest to `wanted`; nullopt if there is none.
  std::optional<std::size_t> cut_between_lines(const Frames& sorted, LineAxis along,
                                               std::size_t wanted) const {
    const auto distance = [&](std::size_t below) {
      return below < wanted ? wanted - below : below - wanted;
    };
    const auto least = static_cast<std::size_t>(kLeastSide * static_cast<double>(sorted.size()));
    const std::vector<double> lines_m = lines_across(set_, sorted, along);
    std::optional<std::size_t> best;
    for (std::size_t i = 1; i < lines_m.size(); ++i) {
      if (lines_m[i] - lines_m[i - 1] < kLeastGap * cell_m_) continue;
      const double middle_m = 0.5 * (lines_m[i] + lines_m[i - 1]);
      const auto end = std::partition_point(sorted.begin(), sorted.end(), [&](int frame) {
        return at_m(set_, frame, along) < middle_m;
      });
      const auto below = static_cast<std::size_t>(end - sorted.begin());
      if (below <= least || below + least >= sorted.size()) continue;
      if (!best || distance(below) < distance(*best)) best = below;
    }
    return best;
  }

  const CaptureSet& set_;
  double cell_m_;
  std::size_t most_ = 1;
  std::vector<Frames> groups_{};
};

// By frame: its part, or kNoPart.
using PartOfFrame = std::vector<int>;

int part_of(const PartOfFrame& parts, int frame) { return parts[static_cast<std::size_t>(frame)]; }

// The connected frames of every group, in the order of the groups and of their first frames.
std::vector<Frames> connected(const CaptureSet& set, const std::vector<Frames>& groups,
                              std::span<const FramePair> pairs) {
  PartOfFrame group_of(set.frames.size(), kNoPart);
  for (std::size_t group = 0; group < groups.size(); ++group) {
    for (const int frame : groups[group]) {
      group_of[static_cast<std::size_t>(frame)] = static_cast<int>(group);
    }
  }
  DisjointSets sets(static_cast<int>(set.frames.size()));
  for (const FramePair& pair : pairs) {
    const int group = part_of(group_of, pair.first);
    if (group != kNoPart && group == part_of(group_of, pair.second)) {
      sets.join(pair.first, pair.second);
    }
  }
  std::vector<Frames> found;
  for (const Frames& group : groups) {
    std::map<int, std::size_t> by_root;
    for (const int frame : group) {
      const auto [at, is_new] = by_root.try_emplace(sets.root(frame), found.size());
      if (is_new) found.emplace_back();
      found[at->second].push_back(frame);
    }
  }
  return found;
}

// The part that frames are matched with most, not counting what is not of a part; the first of
// several, kNoPart if there is none.
int nearest_part(const std::map<int, std::vector<int>>& partners, const Frames& frames,
                 const PartOfFrame& parts) {
  std::map<int, int> matched;
  for (const int frame : frames) {
    const auto of_frame = partners.find(frame);
    if (of_frame == partners.end()) continue;
    for (const int partner : of_frame->second) {
      if (part_of(parts, partner) != kNoPart) ++matched[part_of(parts, partner)];
    }
  }
  const auto most = std::max_element(matched.begin(), matched.end(),
                                     [](auto& a, auto& b) { return a.second < b.second; });
  return most == matched.end() ? kNoPart : most->first;
}

class HomeChooser {
 public:
  HomeChooser(const CaptureSet& set, std::span<const FramePair> pairs)
      : parts_(set.frames.size(), kNoPart) {
    for (const FramePair& pair : pairs) {
      partners_[pair.first].push_back(pair.second);
      partners_[pair.second].push_back(pair.first);
    }
  }

  void found_part(const Frames& frames) { put(frames, static_cast<int>(homes_.size())); }
  // Frames too few for a part of their own, unless nothing connects them.
  void add(const Frames& frames) {
    const int part = nearest_part(partners_, frames, parts_);
    put(frames, part == kNoPart ? static_cast<int>(homes_.size()) : part);
  }
  std::vector<Frames> homes() const {
    std::vector<Frames> sorted = homes_;
    for (Frames& home : sorted) std::sort(home.begin(), home.end());
    return sorted;
  }

 private:
  void put(const Frames& frames, int part) {
    if (static_cast<std::size_t>(part) == homes_.size()) homes_.emplace_back();
    for (const int frame : frames) {
      homes_[static_cast<std::size_t>(part)].push_back(frame);
      parts_[static_cast<std::size_t>(frame)] = part;
    }
  }

  std::map<int, std::vector<int>> partners_{};
  PartOfFrame parts_;
  std::vector<Frames> homes_{};
};

// The keyframes of every line, in order along it.
std::vector<Frames> keyframes_by_line(const CaptureSet& set, std::span<const int> keyframes) {
  std::vector<Frames> by_line;
  for (const CaptureLine& line : set.lines) {
    Frames& of_line = by_line.emplace_back();
    std::copy_if(
        line.frames.begin(), line.frames.end(), std::back_inserter(of_line),
        [&](int frame) { return std::binary_search(keyframes.begin(), keyframes.end(), frame); });
  }
  return by_line;
}

bool is_in(const Frames& frames, int frame) {
  return std::binary_search(frames.begin(), frames.end(), frame);
}

// Adds the keyframes of a line that are close to one at home.
void add_beyond(const Frames& line, const Frames& home, Frames* frames) {
  for (std::ptrdiff_t i = 0; i < std::ssize(line); ++i) {
    if (!is_in(home, line[static_cast<std::size_t>(i)])) continue;
    const auto from = line.begin() + std::max<std::ptrdiff_t>(0, i - kBeyondHome);
    const auto to = line.begin() + std::min(std::ssize(line), i + kBeyondHome + 1);
    frames->insert(frames->end(), from, to);
  }
}

PosePart part_around(const Frames& home, const std::vector<Frames>& lines,
                     std::span<const FramePair> pairs) {
  PosePart part{.home = home, .frames = home, .pairs = {}};
  for (const FramePair& pair : pairs) {
    if (is_in(home, pair.first)) part.frames.push_back(pair.second);
    if (is_in(home, pair.second)) part.frames.push_back(pair.first);
  }
  for (const Frames& line : lines) add_beyond(line, home, &part.frames);
  std::sort(part.frames.begin(), part.frames.end());
  part.frames.erase(std::unique(part.frames.begin(), part.frames.end()), part.frames.end());
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(part.pairs),
               [&](const FramePair& pair) {
                 return is_in(part.frames, pair.first) && is_in(part.frames, pair.second);
               });
  return part;
}

}  // namespace

std::vector<PosePart> divide_grid(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                  std::span<const int> keyframes, std::span<const FramePair> pairs,
                                  int most_stations) {
  Frames stations;
  Frames held_out;
  for (const int frame : keyframes) {
    const bool station = !set.frames[static_cast<std::size_t>(frame)].held_out();
    (station ? stations : held_out).push_back(frame);
  }
  if (std::ssize(stations) <= most_stations) {
    const Frames all(keyframes.begin(), keyframes.end());
    return {{.home = all, .frames = all, .pairs = {pairs.begin(), pairs.end()}}};
  }
  Divider divider(set, cell_side_m(set, crossings), most_stations);
  const std::vector<Frames> groups = connected(set, divider.divide(stations), pairs);
  HomeChooser chooser(set, pairs);
  const auto is_large = [&](const Frames& group) {
    return static_cast<double>(group.size()) >= kLeastPart * most_stations;
  };
  for (const Frames& group : groups) {
    if (is_large(group)) chooser.found_part(group);
  }
  for (const Frames& group : groups) {
    if (!is_large(group)) chooser.add(group);
  }
  for (const int frame : held_out) chooser.add({frame});
  std::vector<PosePart> parts;
  const std::vector<Frames> lines = keyframes_by_line(set, keyframes);
  for (const Frames& home : chooser.homes()) parts.push_back(part_around(home, lines, pairs));
  return parts;
}

}  // namespace raywalk::calibrate
