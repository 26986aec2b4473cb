#include "core/geometry/crossing_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr int kUndecided = -1;

class CrossingAssignment {
 public:
  CrossingAssignment(std::span<const StationPose> stations, double tolerance_m,
                     std::vector<StationGroup>* groups)
      : stations_(stations), tolerance_m_(tolerance_m), tree_(tree_of(stations)), groups_(*groups) {
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
      if (crossing.stations.size() == 2) {
        split_pair(crossing.x_line, crossing.z_line, crossing.stations, settled);
      }
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
      const auto any = [](int) { return true; };
      for (const int station : stations_near(tree_, line(index), tolerance_m_, any)) {
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
      const int alone = own.empty() ? group.stations.front() : own.front();
      require_own_position(stations_, tree_, alone, tolerance_m_);
      throw Error(
          fmt::format("{} is on no line: it lines up only with stations of lines that cross "
                      "there; a line needs at least two stations of its own",
                      name(alone)));
    }
  }

  void require_two_at_most(const std::vector<int>& shared) const {
    if (shared.size() <= 2) return;
    throw Error(
        fmt::format("{}, {} and {} all lie within {:.3g} mm of the crossing of two lines, where "
                    "each line has one station; remove the repeated one or lower the line "
                    "tolerance",
                    name(shared[0]), name(shared[1]), name(shared[2]), tolerance_m_ * 1e3));
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
    const auto kept_together = [&](const std::vector<int>& order) {
      int count = 0;
      for (size_t i = 1; i < order.size(); ++i) {
        const int before = settled[static_cast<size_t>(order[i - 1])];
        if (before != kUndecided && before == settled[static_cast<size_t>(order[i])]) ++count;
      }
      return count;
    };
    order_ = kept_together(by_name) > kept_together(listed) ? by_name : listed;
    rank_.resize(order_.size());
    for (size_t i = 0; i < order_.size(); ++i) {
      rank_[static_cast<size_t>(order_[i])] = static_cast<int>(i);
    }
  }

  // How many of a station's two neighbours in capture order are settled members of the line.
  int neighbours_on(int station, int line_index, const std::vector<int>& settled) const {
    int count = 0;
    for (int step : {-1, 1}) {
      const int rank = rank_[static_cast<size_t>(station)] + step;
      if (rank < 0 || rank >= static_cast<int>(order_.size())) continue;
      const int neighbour = order_[static_cast<size_t>(rank)];
      if (settled[static_cast<size_t>(neighbour)] == line_index) ++count;
    }
    return count;
  }

  void split_pair(int x_line, int z_line, const std::vector<int>& pair,
                  const std::vector<int>& settled) {
    const auto fit = [&](int on_x, int on_z) {
      return neighbours_on(on_x, x_line, settled) + neighbours_on(on_z, z_line, settled);
    };
    const bool swapped = fit(pair[1], pair[0]) > fit(pair[0], pair[1]);
    owner(pair[swapped ? 1 : 0]) = x_line;
    owner(pair[swapped ? 0 : 1]) = z_line;
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
    bool worse_than(const Hole& other) const {
      return std::pair(is_end, spacings) > std::pair(other.is_end, other.spacings);
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
      for (const auto& [along_m, station] : members(index)) stations.push_back(station);
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
  double tolerance_m_;
  StationTree tree_;
  std::vector<StationGroup>& groups_;
  std::vector<int> owner_;                 // group of each station
  std::vector<std::set<Member>> members_;  // of each group, in order along it
  std::vector<int> order_;                 // stations in the order they were captured
  std::vector<int> rank_;                  // place of each station in order_
};

}  // namespace

void assign_crossing_stations(std::span<const StationPose> stations, double tolerance_m,
                              std::vector<StationGroup>* groups) {
  CrossingAssignment(stations, tolerance_m, groups).run();
}

}  // namespace raywalk
