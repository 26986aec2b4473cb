#include "capture/session/plan_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace raywalk::capture {
namespace {

constexpr double kSame_m = 1e-6;
constexpr double kSame_mm = 1e3 * kSame_m;

bool is_same_place(const PlanPoint& a, const PlanPoint& b) {
  return std::abs(a.x_m - b.x_m) <= kSame_m && std::abs(a.z_m - b.z_m) <= kSame_m;
}

std::string station_difference(const CaptureStation& there, const CaptureStation& here) {
  if (there.name != here.name) {
    return fmt::format("station {} there is {} here", there.name, here.name);
  }
  if (!is_same_place(there.position_m, here.position_m)) {
    return fmt::format(
        "station {} lies at x = {:.6g}, z = {:.6g} m there, x = {:.6g}, z = {:.6g} "
        "m here",
        there.name, there.position_m.x_m, there.position_m.z_m, here.position_m.x_m,
        here.position_m.z_m);
  }
  if (std::abs(there.rail_mm - here.rail_mm) > kSame_mm) {
    return fmt::format("station {} lies at {:.6g} mm on the rail there, {:.6g} mm here", there.name,
                       there.rail_mm, here.rail_mm);
  }
  return "";
}

std::string kind_of(const CaptureLine& line) {
  return fmt::format("{}along {}", line.validation ? "for validation " : "", name_of(line.axis));
}

std::string line_difference(const CaptureLine& there, const CaptureLine& here) {
  if (there.id != here.id) return fmt::format("line {} there is {} here", there.id, here.id);
  if (kind_of(there) != kind_of(here)) {
    return fmt::format("line {} is {} there, {} here", there.id, kind_of(there), kind_of(here));
  }
  if (there.stations.size() != here.stations.size()) {
    return fmt::format("line {} has {} stations there, {} here", there.id, there.stations.size(),
                       here.stations.size());
  }
  for (std::size_t i = 0; i < there.stations.size(); ++i) {
    std::string difference = station_difference(there.stations[i], here.stations[i]);
    if (!difference.empty()) return difference;
  }
  return "";
}

}  // namespace

std::string plan_difference(const CapturePlan& there, const CapturePlan& here) {
  const std::size_t common = std::min(there.lines.size(), here.lines.size());
  for (std::size_t i = 0; i < common; ++i) {
    std::string difference = line_difference(there.lines[i], here.lines[i]);
    if (!difference.empty()) return difference;
  }
  if (there.lines.size() == here.lines.size()) return "";
  return fmt::format("it has {} lines there, {} here", there.lines.size(), here.lines.size());
}

}  // namespace raywalk::capture
