#include "core/geometry/crossing_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/length_text.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/unplaced_stations.h"

namespace raywalk {
namespace {

constexpr int kUndecided = -1;
// Of the pairs of settled stations that follow each other, the share on one line from which on the
// order tells something.
constexpr double kFollowingShare = 0.5;

class CrossingAssignment {
 public:
  CrossingAssignment(std::span<const StationPose> stations, const LineLimits& limits,
                     std::vector<StationGroup>* groups)
      : stations_(stations), limits_(limits), tree_(tree_of(stations)), groups_(*groups) {
    owner_.resize(stations.size(), kUndecided);
    for (size_t group = 0; group < groups_.size(); ++group) {
      for (int station : groups_[group].stations) owner(station) = static_cast<int>(group);
    }
  }

  void run() {
    const std::vector<Crossing> crossings = find_crossings();
    require_own_stations(crossings);
    std::vector<int> settled = owner_;
    for (const Crossing& crossing : crossings) {
      for (int station : crossing.stations) settled[static_cast<size_t>(station)] = kUndecided;
    }
    choose_order(settled);
    for (const Crossing& crossing : crossings) {
      if (crossing.stations.size() > 1) share_out(crossing, settled);
    }
    sort_members();
    for (const Crossing& crossing : crossings) {
      if (crossing.stations.size() == 1) {
        give_single(crossing.x_line, crossing.z_line, crossing.stations[0]);
      }
    }
    collect();
  }

 private:
  using Member = std::pair<double, int>;  // a station's position along its line, and its index

  struct Crossing {
    int x_line, z_line;
    std::vector<int> stations;
  };

  // In the order of their lines; stations ascend.
  std::vector<Crossing> find_crossings() const {
    std::vector<std::array<std::vector<int>, 2>> lines_at(stations_.size());  // along x and z
    for (int index = 0; index < line_count(); ++index) {
      for (const int station : stations_on(index)) {
        lines_at[static_cast<size_t>(station)][line(index).axis == LineAxis::kX ? 0 : 1].push_back(
            index);
      }
    }
    std::map<std::pair<int, int>, std::vector<int>> stations_at;
    for (int station = 0; station < tree_.size(); ++station) {
      const auto& [x_lines, z_lines] = lines_at[static_cast<size_t>(station)];
      for (const int x_line : x_lines) {
        for (const int z_line : z_lines) stations_at[{x_line, z_line}].push_back(station);
      }
    }
    std::vector<Crossing> crossings;
    for (auto& [lines, shared] : stations_at) {
      require_two_at_most(shared);
      crossings.push_back({lines.first, lines.second, std::move(shared)});
    }
    return crossings;
  }

  // The stations within tolerance of a line, whatever line they are of: those between its ends, and
  // as far beyond them as a line may have lost stations.
  std::vector<int> stations_on(int index) const {
    constexpr double kReachInSpacings = 4.0 + kOffPlaceShare;
    std::vector<double> along_m;
    for (const int station : groups_[static_cast<size_t>(index)].stations) {
      along_m.push_back(along(index, station));
    }
    std::sort(along_m.begin(), along_m.end());
    std::vector<double> gaps_m;
    for (size_t i = 1; i < along_m.size(); ++i) gaps_m.push_back(along_m[i] - along_m[i - 1]);
    const double reach_m =
        std::max(limits_.off_line_m, kReachInSpacings * covering_spacing(std::move(gaps_m)));
    return stations_near(tree_, line(index), limits_.off_line_m, [&](int station) {
      const double at_m = along(index, station);
      return at_m >= along_m.front() - reach_m && at_m <= along_m.back() + reach_m;
    });
  }

  // A stray station can form a spurious line with stations of the lines around it. A real line has
  // at least two stations of its own; a single station at a crossing is no evidence for it.
  void require_own_stations(const std::vector<Crossing>& crossings) const {
    std::vector<bool> shared(stations_.size(), false);
    for (const Crossing& crossing : crossings) {
      if (crossing.stations.size() == 1) shared[static_cast<size_t>(crossing.stations[0])] = true;
    }
    for (const StationGroup& group : groups_) {
      std::vector<int> own;
      std::copy_if(group.stations.begin(), group.stations.end(), std::back_inserter(own),
                   [&](int station) { return !shared[static_cast<size_t>(station)]; });
      if (own.size() >= 2) continue;
      throw_without(group, own.empty() ? group.stations.front() : own.front());
    }
  }

  // Throws for a station of a line that has no stations of its own.
  [[noreturn]] void throw_without(const StationGroup& spurious, int station) const {
    std::vector<StationGroup> others;
    std::copy_if(groups_.begin(), groups_.end(), std::back_inserter(others),
                 [&](const StationGroup& group) { return &group != &spurious; });
    throw_unplaced(stations_, limits_, others, {&station, 1});
  }

  // Of the stations at a crossing no three count as one.
  void require_two_at_most(const std::vector<int>& shared) const {
    for (size_t a = 0; a < shared.size(); ++a) {
      std::vector<int> same{shared[a]};
      for (size_t b = a + 1; b < shared.size(); ++b) {
        if (count_as_one(shared[a], shared[b])) same.push_back(shared[b]);
      }
      if (same.size() <= 2) continue;
      throw Error(fmt::format(
          "{}, {} and {} are at one place (within {}) where two lines cross, and each line has one "
          "station there; remove one of them or give a smaller --same-station-mm",
          name(same[0]), name(same[1]), name(same[2]), mm_text(limits_.same_station_m)));
    }
  }
  bool count_as_one(int a, int b) const {
    return (tree_.point(a) - tree_.point(b)).norm() <= limits_.same_station_m;
  }

  // The order of the list, or of the file names if that better keeps the settled stations of each
  // line together.
  void choose_order(const std::vector<int>& settled) {
    std::vector<int> listed(stations_.size());
    std::iota(listed.begin(), listed.end(), 0);
    std::vector<int> by_name = listed;
    std::stable_sort(by_name.begin(), by_name.end(), [&](int a, int b) {
      return stations_[static_cast<size_t>(a)].file < stations_[static_cast<size_t>(b)].file;
    });
    // Of the pairs that follow each other but for stations at crossings.
    const auto kept_together = [&](const std::vector<int>& order) {
      int count = 0, before = kUndecided;
      for (const int station : order) {
        const int line = settled[static_cast<size_t>(station)];
        if (line == kUndecided) continue;
        if (line == before) ++count;
        before = line;
      }
      return count;
    };
    const int by_name_count = kept_together(by_name), listed_count = kept_together(listed);
    order_ = by_name_count > listed_count ? by_name : listed;
    const auto pairs = static_cast<double>(
        std::count_if(settled.begin(), settled.end(), [](int line) { return line != kUndecided; }) -
        1);
    order_follows_lines_ = std::max(by_name_count, listed_count) > kFollowingShare * pairs;
    rank_.resize(order_.size());
    for (size_t i = 0; i < order_.size(); ++i) {
      rank_[static_cast<size_t>(order_[i])] = static_cast<int>(i);
    }
  }

  // What the capture order says of a station at a crossing.
  struct Lean {
    double to_x = 0.0;  // positive: rather of the line along x; negative: of the one along z
    bool firm = false;  // its settled neighbours on both sides are of that line
  };

  // By the nearest settled station before and after it: the nearer they are, the more they tell.
  Lean lean_of(int station, const Crossing& crossing, const std::vector<int>& settled) const {
    if (!order_follows_lines_) return {};
    Lean lean{.firm = true};
    for (const int step : {-1, 1}) {
      int rank = rank_[static_cast<size_t>(station)] + step, steps = 1;
      const auto is_in_list = [&] { return rank >= 0 && rank < static_cast<int>(order_.size()); };
      const auto line_there = [&] {
        return settled[static_cast<size_t>(order_[static_cast<size_t>(rank)])];
      };
      for (; is_in_list() && line_there() == kUndecided; rank += step) ++steps;
      if (!is_in_list()) continue;
      const double sign = line_there() == crossing.x_line   ? 1.0
                          : line_there() == crossing.z_line ? -1.0
                                                            : 0.0;
      lean.firm &= sign != 0.0 && sign * lean.to_x >= 0.0;
      lean.to_x += sign / steps;
    }
    lean.firm &= lean.to_x != 0.0;
    return lean;
  }

  // How much nearer a station is to the line along x than to the one along z.
  double nearer_to_x(int station, const Crossing& crossing) const {
    return line(crossing.z_line).distance_to(tree_.point(station)) -
           line(crossing.x_line).distance_to(tree_.point(station));
  }

  // Two stations are one of each line, unless both are firmly of one. More are on the lines that
  // the capture order says, or the nearer, as long as two that count as one are of different lines.
  void share_out(const Crossing& crossing, const std::vector<int>& settled) {
    const std::vector<int>& shared = crossing.stations;
    std::map<int, Lean> leans;
    for (const int station : shared) leans[station] = lean_of(station, crossing, settled);
    const auto is_rather_of_x = [&](int a, int b) {
      return std::tuple(leans[a].to_x, nearer_to_x(a, crossing), name(b)) >=
             std::tuple(leans[b].to_x, nearer_to_x(b, crossing), name(a));
    };
    const auto split = [&](int a, int b) {
      const bool swapped = !is_rather_of_x(a, b);
      owner(swapped ? b : a) = crossing.x_line;
      owner(swapped ? a : b) = crossing.z_line;
    };
    const bool one_line = leans[shared[0]].firm && leans[shared[1]].firm &&
                          leans[shared[0]].to_x * leans[shared[1]].to_x > 0.0;
    if (shared.size() == 2 && !one_line) return split(shared[0], shared[1]);
    for (const int station : shared) {
      const double to_x =
          leans[station].to_x != 0.0 ? leans[station].to_x : nearer_to_x(station, crossing);
      owner(station) = to_x >= 0.0 ? crossing.x_line : crossing.z_line;
    }
    for (size_t a = 0; a < shared.size(); ++a) {
      for (size_t b = a + 1; b < shared.size(); ++b) {
        if (count_as_one(shared[a], shared[b])) split(shared[a], shared[b]);
      }
    }
  }

  void give_single(int x_line, int z_line, int station) {
    const int wanted =
        hole_without(z_line, station).worse_than(hole_without(x_line, station)) ? z_line : x_line;
    const int current = owner(station);
    if (current == wanted || members(current).size() <= 2) return;
    members(current).erase({along(current, station), station});
    members(wanted).insert({along(wanted, station), station});
    owner(station) = wanted;
  }

  // The loss to a line without the station: whether it would lose its end, which cannot be
  // interpolated; then the remaining gap, in units of the line's mean spacing.
  struct Hole {
    bool is_end;
    double spacings;
    // By more than stations may be off their places: equal holes do not depend on rounding.
    bool worse_than(const Hole& other) const {
      return std::pair(is_end, spacings) > std::pair(other.is_end, other.spacings + kOffPlaceShare);
    }
  };
  Hole hole_without(int line_index, int station) {
    const double at = along(line_index, station);
    std::set<Member>& others = members(line_index);
    const bool is_member = others.erase({at, station}) > 0;
    double before = -1.0, after = -1.0, first = at, last = at;
    const auto next = others.lower_bound({at, -1});
    if (next != others.begin()) before = std::abs(std::prev(next)->first - at);
    if (next != others.end()) after = std::abs(next->first - at);
    if (!others.empty()) {
      first = std::min(first, at + (others.begin()->first - at));
      last = std::max(last, at + (others.rbegin()->first - at));
    }
    const double mean_spacing =
        (last - first) / static_cast<double>(std::max<size_t>(1, others.size()));
    if (is_member) others.insert({at, station});
    const double hole = std::max(before, 0.0) + std::max(after, 0.0);
    const bool is_end = before < 0.0 || after < 0.0;
    return {is_end, mean_spacing > 0.0 ? hole / mean_spacing : 0.0};
  }

  void sort_members() {
    members_.resize(groups_.size());
    for (int station = 0; station < static_cast<int>(stations_.size()); ++station) {
      const int index = owner(station);
      if (index != kUndecided) members(index).insert({along(index, station), station});
    }
  }

  void collect() {
    for (int index = 0; index < line_count(); ++index) {
      std::vector<int>& stations = groups_[static_cast<size_t>(index)].stations;
      stations.clear();
      const std::vector<int> before = std::exchange(stations, {});
      for (const auto& [along_m, station] : members(index)) stations.push_back(station);
      if (stations.size() < 2) throw_without(groups_[static_cast<size_t>(index)], before.front());
    }
  }

  double along(int line_index, int station) const {
    return line(line_index).along(plan_of(stations_[static_cast<size_t>(station)]));
  }
  std::string name(int station) const { return name_of(stations_[static_cast<size_t>(station)]); }
  std::set<Member>& members(int line_index) { return members_[static_cast<size_t>(line_index)]; }
  int& owner(int station) { return owner_[static_cast<size_t>(station)]; }
  const PlanLine& line(int index) const { return groups_[static_cast<size_t>(index)].line; }
  int line_count() const { return static_cast<int>(groups_.size()); }

  std::span<const StationPose> stations_;
  LineLimits limits_;
  StationTree tree_;
  std::vector<StationGroup>& groups_;
  std::vector<int> owner_;                 // group of each station
  std::vector<std::set<Member>> members_;  // of each group, in order along it
  std::vector<int> order_;                 // stations in the order they were captured
  std::vector<int> rank_;                  // place of each station in order_
  bool order_follows_lines_ = false;       // so that it tells which line a station is of
};

}  // namespace

void assign_crossing_stations(std::span<const StationPose> stations, const LineLimits& limits,
                              std::vector<StationGroup>* groups) {
  CrossingAssignment(stations, limits, groups).run();
}

}  // namespace raywalk
