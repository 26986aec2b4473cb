#include "build_lf/depth/frame_warnings.h"

#include <fmt/format.h>

#include <algorithm>

namespace raywalk::build_lf {

std::vector<std::string> warnings_of(const Room& room, const FrameChecks& checks) {
  std::vector<std::string> warnings;
  for (const FrameFinding& finding : checks.frames) {
    const Line& line = room.grid().lines[static_cast<size_t>(finding.other.line)];
    const std::string& other = line.stations[static_cast<size_t>(finding.other.station)].file;
    switch (finding.fault) {
      case FrameFault::kSameFile:
        warnings.push_back(fmt::format("{} is a copy of {}, {:.3f} m away; it is not used",
                                       finding.file, other, finding.measure));
        break;
      case FrameFault::kNotMoved:
        warnings.push_back(fmt::format(
            "{} shows the same as {}: the camera seems not to have moved; it is not used",
            finding.file, other));
        break;
      case FrameFault::kUnlikeNeighbours:
        warnings.push_back(fmt::format(
            "{} differs from {} {:.1f} times more than its neighbours do from one another: "
            "something moved, or the frame is misplaced; it is not used",
            finding.file, other, finding.measure));
        break;
      case FrameFault::kExposureStep:
        warnings.push_back(fmt::format(
            "the exposure of {} is {:.2f} times that of {}; its colours are scaled for matching",
            finding.file, finding.measure, other));
        break;
    }
  }
  for (const LineFinding& finding : checks.lines) {
    const std::string& line = room.grid().lines[static_cast<size_t>(finding.line)].id;
    warnings.push_back(
        finding.fault == LineFault::kTooShort
            ? fmt::format(
                  "line {} is {:.3f} m long; estimating distances from it alone needs {:.3f} m",
                  line, finding.measure_m, finding.needed_m)
            : fmt::format("line {} has a gap of {:.3f} m; stations further apart than {:.3f} m "
                          "cannot be compared",
                          line, finding.measure_m, finding.needed_m));
  }
  return warnings;
}

std::vector<std::string> parallax_warnings(std::span<const MapSummary> maps, double far_m) {
  constexpr double kMinShare = 0.01;  // false matches
  std::vector<std::string> warnings;
  for (size_t first = 0, end = 0; first < maps.size(); first = end) {
    double share = 0.0;
    for (; end < maps.size() && maps[end].line == maps[first].line; ++end) {
      share = std::max(share, maps[end].parallax_share);
    }
    if (share >= kMinShare) continue;
    warnings.push_back(fmt::format(
        "line {} shows no parallax: its view is farther than {:.3g} m or without texture, or "
        "the camera did not move along it",
        maps[first].line, far_m));
  }
  return warnings;
}

}  // namespace raywalk::build_lf
