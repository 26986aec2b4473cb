#include "build_lf/gains/gain_windows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

namespace raywalk::build_lf {
namespace {

constexpr int kSteps = 2;  // from one station to those it is compared with

using Groups = std::vector<std::vector<int>>;

void halve(std::span<const Eigen::Vector3d> positions_m, std::vector<int> stations,
           std::size_t most, Groups* groups) {
  if (stations.size() <= most) {
    std::ranges::sort(stations);
    groups->push_back(std::move(stations));
    return;
  }
  Eigen::AlignedBox3d box;
  for (const int s : stations) box.extend(positions_m[static_cast<size_t>(s)]);
  const Eigen::Index axis = box.sizes().x() > box.sizes().z() ? 0 : 2;
  std::ranges::sort(stations, {}, [&](int s) {
    return std::make_pair(positions_m[static_cast<size_t>(s)][axis], s);
  });
  const auto middle = stations.begin() + static_cast<std::ptrdiff_t>(stations.size() / 2);
  halve(positions_m, {stations.begin(), middle}, most, groups);
  halve(positions_m, {middle, stations.end()}, most, groups);
}

}  // namespace

std::vector<GainWindow> gain_windows(std::span<const Eigen::Vector3d> positions_m,
                                     std::span<const WholeRatio> pairs, int most) {
  std::vector<int> all(positions_m.size());
  std::iota(all.begin(), all.end(), 0);
  Groups groups;
  halve(positions_m, std::move(all), static_cast<size_t>(most), &groups);
  Groups compared(positions_m.size());
  for (const WholeRatio& pair : pairs) compared[static_cast<size_t>(pair.to)].push_back(pair.from);
  std::vector<GainWindow> windows;
  for (const std::vector<int>& group : groups) {
    std::vector<int> members = group;
    for (int step = 0; step < kSteps; ++step) {
      std::vector<int> around;
      for (const int s : members) {
        const std::vector<int>& others = compared[static_cast<size_t>(s)];
        around.insert(around.end(), others.begin(), others.end());
      }
      members.insert(members.end(), around.begin(), around.end());
      std::ranges::sort(members);
      members.erase(std::unique(members.begin(), members.end()), members.end());
    }
    GainWindow& window = windows.emplace_back();
    window.stations = std::move(members);
    for (const int s : window.stations) {
      window.kept.push_back(std::binary_search(group.begin(), group.end(), s));
    }
  }
  return windows;
}

}  // namespace raywalk::build_lf
